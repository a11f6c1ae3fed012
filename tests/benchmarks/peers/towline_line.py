"""A case run by Towline: a scenario stepped by the compiled native loop, every output captured, nothing written."""

import time

import numpy as np
from peers.case import POINTS, Trace

from components.tether.cable.model import Cable
from pipeline.conductor import Conductor
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

NAME = "Towline"


def lacks(case) -> str:
    """The parameter that this Towline's cable would need for the case and has not, or nothing."""
    wanted = {"bending_stiffness": case.bending, "current": case.current, "seabed": case.seabed}
    return next((name for name, value in wanted.items() if value and name not in Cable.model_fields), "")


def scenario(case, segments: int, step: float, options: dict[str, str]) -> str:
    """The case as YAML."""

    def vector(values):
        return "[" + ", ".join(f"{v!r} m" for v in values) + "]"

    if case.bending:
        options = {"bending_stiffness": f"{case.bending!r} N m^2", **options}
    if case.current:
        options = {"current": f"[{case.current!r} m/s, 0 m/s, 0 m/s]", **options}
    if case.seabed:
        options = {
            "seabed": f"{case.seabed.depth!r} m",
            "seabed_stiffness": f"{case.seabed.stiffness * case.diameter!r} N/m^2",
            "seabed_damping_time": f"{case.seabed.damping / case.seabed.stiffness!r} s",
            **options,
        }
    optional = "".join(f"      {key}: {value}\n" for key, value in options.items())
    return f"""
name: {case.name}
duration: {case.duration} s
step: {round(step * 1e9)} ns
components:
  fixed:
    model: motion.fixed
    parameters: {{position: {vector(case.fixed)}}}
  moving:
    model: motion.ellipse
    parameters:
      centre: {vector(case.centre)}
      cosine: {vector(case.cosine)}
      sine: {vector(case.sine)}
      frequency: {case.frequency!r} Hz
      ramp: {case.ramp!r} s
  line:
    model: tether.cable
    parameters:
      length: {case.length!r} m
      segments: {segments}
      mass_per_length: {case.mass!r} kg/m
      volume_per_length: {case.area!r} m^2
      drag_diameter: {case.diameter!r} m
      axial_stiffness: {case.stiffness!r} N
      damping_time: {case.damping / case.stiffness!r} s
      normal_drag: {case.drag_n!r}
      tangential_drag: {case.drag_t!r}
      normal_added_mass: {case.added_n!r}
      tangential_added_mass: {case.added_t!r}
      fluid_density: {case.density!r} kg/m^3
{optional}    inputs: {{end_a: fixed.motion, end_b: moving.motion}}
"""


def run(case, segments: int, step: float, repeats: int = 1, **options: str) -> Trace:
    """A Trace; its loop time is the median of `repeats` runs. options: further parameters of tether.cable."""
    loops, calls = [], []
    for _ in range(repeats):
        began = time.thread_time()
        parsed = load_scenario_text(scenario(case, segments, step, options), case.name, ".")
        conductor = Conductor(build_graph(parsed))
        rows = []
        conductor.initialise()
        rows += [values.copy() for channel, values in conductor.captured() if channel == _line(conductor)]
        ready = time.thread_time()
        for _ in conductor.run(conductor.graph.ticks):
            rows += [values.copy() for channel, values in conductor.captured() if channel == _line(conductor)]
        ended = time.thread_time()
        loops.append(ended - ready)
        calls.append(ended - began)
    y = np.concatenate(rows)[:: round(case.sample / step), 1:]
    nodes = y[:, : 3 * (segments + 1)].reshape(len(y), segments + 1, 3)
    forces = y[:, 4 * segments + 3 : 4 * segments + 9].reshape(len(y), 2, 3)
    return Trace(
        np.linalg.norm(forces, axis=2),
        nodes[:, :: segments // POINTS],
        float(np.median(loops)),
        float(np.median(calls)),
        {"iterations": float(np.concatenate(rows)[1:, 1 + 4 * segments + 11].mean())},
    )


def _line(conductor) -> int:
    return [node.name for node in conductor.graph.nodes].index("line")
