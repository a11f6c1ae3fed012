"""The nonlinear passive observer."""
