"""Observed order of convergence of tether.cable in time and in space, for positions and end tensions.

The pool chain of tether.py. Each run is compared with the next of half the step or half the segment length; the order
is log2 of how the difference shrinks from one pair to the next, so that no reference is needed. The tolerance of the
balance is set so small that it does not show.
"""

from math import log2

from peers import towline_line
from tether import CHAIN, position_error, tension_error

TOLERANCE = "1e-11"
STEPS, SEGMENTS = (0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003125), 40  # s; where only they change
COUNTS, STEP = (10, 20, 40, 80, 160, 320), 0.005  # s; where only the segments change


def _differences(runs: dict[str, object], method: str, held: str) -> list[dict]:
    """A row for each run but the last, the order from the second on."""
    labels, traces = list(runs), list(runs.values())
    table = []
    for k, label in enumerate(labels[:-1]):
        now = {
            "tension": tension_error(traces[k], traces[k + 1]),
            "position": position_error(traces[k], traces[k + 1]),
        }
        last = table[-1] if table else None
        table.append(
            {
                "case": label,
                "method": method,
                "held": held,
                "error": now["tension"],
                "error_unit": "% of the end tensions, rms",
                "position_error_mm": now["position"],
                "tension_order": log2(last["error"] / now["tension"]) if last else None,
                "position_order": log2(last["position_error_mm"] / now["position"]) if last else None,
                "reference": "the next row's run",
            }
        )
    return table


def rows() -> list[dict]:
    """Time first, then space."""
    in_time = {f"{1e3 * h:g} ms": towline_line.run(CHAIN, SEGMENTS, h, tolerance=TOLERANCE) for h in STEPS}
    in_space = {f"{n} segments": towline_line.run(CHAIN, n, STEP, tolerance=TOLERANCE) for n in COUNTS}
    return [
        *_differences(in_time, "time", f"{SEGMENTS} segments"),
        *_differences(in_space, "space", f"{1e3 * STEP:g} ms"),
    ]
