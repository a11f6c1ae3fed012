"""A process of its own for one FMU in libcosim, which ends the whole process where an FMU fails.

Its argument: {"path", "step_ns", "steps", "inputs" to hold: [[value reference, value]], "outputs": [value reference],
"out": where the outputs after each step go}. It imports little, to start in a tenth of a second.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def main() -> None:
    asked = json.loads(sys.argv[1])
    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_step_size(asked["step_ns"])
    slave = CosimLocalSlave(asked["path"], "a")
    at = execution.add_local_slave(slave)
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    for reference, value in asked["inputs"]:
        assert execution.real_initial_value(at, reference, value)
    rows = []
    for _ in range(asked["steps"]):
        assert execution.step()
        rows.append(observer.last_real_values(at, asked["outputs"]))
    Path(asked["out"]).write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
