"""What components of the user's own and foreign FMUs gave, which no other tab knows: a figure for each port."""

from __future__ import annotations

import numpy as np

from components.contract import Port
from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading

FILES = (".py", ".fmu")  # by which models that are not Towline's own are named
CURVES = 6  # of one port: those of larger ports are spread over it
AXES = ("north", "east", "down")


def tab(signals: Signals) -> Tab | None:
    """None where all models are Towline's own. To be made last: what another tab used, it does not draw again."""
    items: list[str | Chart] = []
    for name, info in signals.channels.items():
        ports = [info.port(port)[0] for port in signals.ports(name) if (name, port) not in signals.used]
        ports = [port for port in ports if not _is_places(port)]
        if ports and info.metadata.get("model", "").endswith(FILES):
            items += [heading(name), *(_chart(signals, name, port) for port in ports)]
    return Tab("others", "Own components", items) if items else None


def _is_places(port: Port) -> bool:
    """Points in space, which the animation has."""
    return len(port.shape) == 2 and port.shape[1] == 3 and port.unit == "m"


def _chart(signals: Signals, name: str, port: Port) -> Chart:
    t, values = signals.t(name), signals.rows(name, port.name)
    unit, values = ("°", np.degrees(values)) if port.unit == "rad" else (port.unit, values)
    chosen = np.unique(np.linspace(0, port.size - 1, min(port.size, CURVES)).round().astype(int))
    is_vector = port.shape == (3,) and port.frame == "NED" and port.unit != "rad"
    names = AXES if is_vector else [f"{port.name}[{i}]" if port.size > 1 else port.name for i in range(port.size)]
    said = f"{CURVES} of its {port.size} numbers." if port.size > CURVES else ""
    curves = [Series(names[i], t, values[:, i]) for i in chosen]
    return Chart(port.name, f"{port.name.rpartition('.')[2]} [{unit}]", curves, said)
