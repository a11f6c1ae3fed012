"""What is to be exported: a model with parameters, or a component of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from components.contract import Component, Parameters
from pipeline import catalogue, parameters
from pipeline.errors import Place, Problem, ScenarioError, TowlineError
from pipeline.graph import Node
from pipeline.parameters import Given
from pipeline.ports import faults, size_faults
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph
from pipeline.yaml_source import Table, Tree, parse

DEFAULT_STEP_NS = 10_000_000  # of a model by itself; a component of a scenario has its period
PACKAGE = "components."
OPTION = Place("--param")


@dataclass(frozen=True)
class Instance:
    """A component with its parameters, seed, step and time of init [ns]."""

    component: Component
    parameters: Parameters
    seed: int = 0
    step_ns: int = DEFAULT_STEP_NS
    start_ns: int = 0


def instance(text: str, overrides: Sequence[str]) -> Instance:
    """The instance that a user names: `tether.cable`, `components.tether.cable`, `./own.py` or `scenario.yaml#name`.

    overrides: `parameter=value` in SI or with a unit; for a model by itself also `file=parameters.yaml`.
    Raises TowlineError, ScenarioError with all problems of the parameters.
    """
    path, sign, name = text.rpartition("#")
    if sign:
        return _of_scenario(path, name, overrides)
    return _of_model(text.removeprefix(PACKAGE), overrides)


def _of_scenario(path: str, name: str, overrides: Sequence[str]) -> Instance:
    graph = build_graph(load_scenario(path, [f"{name}.{override}" for override in overrides]))
    nodes: dict[str, Node] = {node.name: node for node in graph.nodes}
    if name not in nodes:
        raise TowlineError(f"{path} has no component '{name}'{catalogue.closest(name, list(nodes))}")
    node = nodes[name]
    return Instance(node.component, node.parameters, node.seed, node.period * graph.base_ns, graph.start_ns)


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
    wrong = [*faults("input", component.inputs(found)), *faults("output", component.outputs(found))]
    for text in (*wrong, *size_faults(component.sizes(found))):
        raise TowlineError(f"{component.name}: {text}")
