"""System structures of other tools: SSP and OSP read into a scenario, a scenario of FMUs written as an SSP."""
