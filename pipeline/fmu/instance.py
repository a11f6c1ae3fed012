"""What is to be exported: a model with parameters, or a component of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from components.contract import Component, Parameters
from pipeline import catalogue, parameters
from pipeline.errors import Place, Problem, ScenarioError, TowlineError
from pipeline.graph import Node
from pipeline.parameters import Given
from pipeline.ports import faults, image_faults, size_faults
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph
from pipeline.yaml_source import Table, Tree, parse

DEFAULT_STEP_NS = 10_000_000  # of a model by itself; a component of a scenario has its period
PACKAGE = "components."
OPTION = Place("--param")


@dataclass(frozen=True)
class Instance:
    """A component with its parameters, seed, step and time of init [ns].

    step_ns: what init is told, and the default experiment's.
    inputs: (n_u,) what they start with, or none for zero.
    """

    component: Component
    parameters: Parameters
    seed: int = 0
    step_ns: int = DEFAULT_STEP_NS
    start_ns: int = 0
    inputs: tuple[float, ...] = ()


def instance(text: str, overrides: Sequence[str]) -> Instance:
    """The instance that a user names: `tether.cable`, `components.tether.cable`, `./own.py` or `scenario.yaml#name`.

    overrides: `parameter=value` in SI or with a unit; for a model by itself also `file=parameters.yaml`.
    Raises TowlineError, ScenarioError with all problems of the parameters.
    """
    path, sign, name = text.rpartition("#")
    if sign:
        return _of_scenario(path, name, overrides)
    if text.endswith((".yaml", ".yml")):
        raise TowlineError(f"{text} is a scenario; name a component of it, such as {text}#tether")
    return _of_model(text.removeprefix(PACKAGE), overrides)


def _of_scenario(path: str, name: str, overrides: Sequence[str]) -> Instance:
    graph = build_graph(load_scenario(path, [f"{name}.{override}" for override in overrides]))
    nodes: dict[str, Node] = {node.name: node for node in graph.nodes}
    if name not in nodes:
        raise TowlineError(f"{path} has no component '{name}'{catalogue.closest(name, list(nodes))}")
    node = nodes[name]
    step_ns = node.period * graph.base_ns
    return Instance(node.component, node.parameters, node.seed, step_ns, graph.start_ns, _known_inputs(node))


def _known_inputs(node: Node) -> tuple[float, ...]:
    """What the scenario says of the inputs at t0: constants, and what delayed wires carry first; others zero."""
    u = np.zeros(sum(port.size for port in node.inputs))
    is_known = np.ones(len(u), bool)
    for term in node.terms:
        span = slice(term.target, term.target + term.count)
        is_known[span] &= term.delayed or term.gain == 0.0
        before = 0.0 if term.assigns else u[span]
        u[span] = before + term.gain * np.array(term.initial or 0.0) + np.array(term.offset or 0.0)
    return tuple(np.where(is_known, u, 0.0).tolist())


def _of_model(model: str, overrides: Sequence[str]) -> Instance:
    try:
        component = catalogue.find(model, Path.cwd())[1]
    except ValueError as error:
        raise TowlineError(str(error)) from error
    problems: list[Problem] = []
    written = dict(found for text in overrides if (found := _override(text, problems)))
    kind, folder = component.parameters, Path.cwd()
    table = Table(written, dict.fromkeys(written, OPTION), OPTION)
    given = parameters.gather(kind, table, folder, "", problems)
    given |= {name: Given(tree, OPTION, folder, is_si=True) for name, tree in written.items() if name in given}
    found = parameters.build(kind, given, OPTION, "", problems)
    if found is None or problems:
        raise ScenarioError(problems)
    _check(component, found)
    return Instance(component, found)


def _override(text: str, problems: list[Problem]) -> tuple[str, Tree] | None:
    name, sign, value = text.partition("=")
    if not (sign and name.strip() and value.strip()):
        problems.append(Problem(OPTION, "", f"'{text[:80]}' gives no parameter; expected name=value"))
        return None
    tree, found = parse(value, "--param")
    problems.extend(Problem(OPTION, name, problem.text) for problem in found)
    return None if tree is None else (name.strip(), tree)


def _check(component: Component, found: Parameters) -> None:
    """What a scenario would refuse of a component's ports."""
    inputs, outputs = component.inputs(found), component.outputs(found)
    wrong = [*faults("input", inputs), *faults("output", outputs), *image_faults(component, (*inputs, *outputs))]
    for text in (*wrong, *size_faults(component.sizes(found))):
        raise TowlineError(f"{component.name}: {text}")
