"""What power bonds lost or made of the energy that went through them."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.known import finite
from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading, table


def tab(signals: Signals) -> Tab | None:
    """None where the log has no bonds."""
    found = signals.having("residual", "throughput", "rounds")
    if not found:
        return None
    header = ["", "residual [J]", "through it [J]", "share [1]", "rounds, mean [1]"]
    items: list[str | Chart] = [table(header, [_row(signals, name) for name in found], "bonds")]
    for name in found:
        t, short = signals.t(name), name.partition("/")[2] or name
        residual, through = (np.nancumsum(signals.port(name, port)) for port in ("residual", "throughput"))
        items += [
            heading(short),
            Chart("Residual energy, summed up", "energy [J]", [Series("residual", t, residual)]),
            Chart("Energy through the bond, summed up", "energy [J]", [Series("throughput", t, through)]),
            Chart("Residual of each step", "energy [J]", [Series("residual", t, signals.port(name, "residual"))]),
            Chart("Rounds of each step", "rounds [1]", [Series("rounds", t, signals.port(name, "rounds"))]),
        ]
    return Tab("bonds", "Power bonds", items)


def _row(signals: Signals, name: str) -> list[str]:
    residual, through = (float(np.nansum(signals.port(name, port))) for port in ("residual", "throughput"))
    share = f"{abs(residual) / through:.2g}" if through else "-"
    known = finite(signals.port(name, "rounds"))
    rounds = f"{known.mean():.3g}" if len(known) else "-"
    return [name.partition("/")[2] or name, f"{residual:.3g}", f"{through:.3g}", share, rounds]
