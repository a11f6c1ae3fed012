"""The sections that a host is to run, as JSON: components by model, parameters, wires and bonds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from components.contract import ImagePort, Port
from pipeline.catalogue import find
from pipeline.errors import TowlineError
from pipeline.graph import Bond, Graph, Node, OtherEnd, Term
from pipeline.hosts.fmu.component import FmuComponent, component_of
from pipeline.sections import Section


class AssignmentError(Exception):
    """What a host is asked to run it cannot run; says why."""


@dataclass(frozen=True)
class Assigned:
    """A section as a host sees it. outside: how many numbers it gets with each request."""

    number: int
    outside: int
    graph: Graph


def to_json(sections: Iterable[Section]) -> list[dict[str, Any]]:
    """One object a section."""
    return [
        {
            "number": section.number,
            "outside": len(section.outside),
            "base_ns": section.graph.base_ns,
            "start_ns": section.graph.start_ns,
            "board": section.graph.board,
            "stages": section.graph.stages,
            "nodes": [_node_to_json(node) for node in section.graph.nodes],
            "bonds": [asdict(bond) for bond in section.graph.bonds],
        }
        for section in sections
    ]


def from_json(sections: list[dict[str, Any]]) -> list[Assigned]:
    """Raises AssignmentError where this machine lacks a component, or has one that differs."""
    return [_section(section) for section in sections]


def _node_to_json(node: Node) -> dict[str, Any]:
    return {
        "name": node.name,
        "model": node.model,
        "file_hash": _file_hash(Path(node.model)) if node.model.endswith(".py") else "",
        "fmu": _fmu_to_json(node),
        "parameters": node.parameters.model_dump(mode="json"),
        "seed": node.seed,
        "period": node.period,
        "start": node.start,
        "inputs": _ports_to_json(node.inputs),
        "outputs": _ports_to_json(node.outputs),
        "terms": [asdict(term) for term in node.terms],
    }


def _fmu_to_json(node: Node) -> dict[str, str]:
    """The file's hash and the interface of an FMU; nothing of others. A host is a process of its own already."""
    if not isinstance(node.component, FmuComponent):
        return {}
    return {"hash": node.component.description.digest, "interface": node.component.interface.name}


def _ports_to_json(ports: Iterable[Port]) -> list[list[Any]]:
    return [[port.name, port.unit, list(port.shape), port.frame, isinstance(port, ImagePort)] for port in ports]


def _file_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _section(section: dict[str, Any]) -> Assigned:
    stages = tuple(tuple(tuple(group) for group in stage) for stage in section["stages"])
    graph = Graph(
        base_ns=section["base_ns"],
        ticks=0,
        nodes=tuple(_node(node) for node in section["nodes"]),
        stages=stages,
        board=section["board"],
        bonds=tuple(_bond(bond) for bond in section["bonds"]),
        start_ns=section["start_ns"],
    )
    return Assigned(section["number"], section["outside"], graph)


def _node(node: dict[str, Any]) -> Node:
    name, model = node["name"], node["model"]
    try:
        fmu = node["fmu"]
        model = _local_file(model, fmu.get("hash", "") or node["file_hash"])
        if fmu:
            component = component_of(Path(model), fmu["interface"])
        else:
            model, component = find(model, Path.cwd())
        parameters = component.parameters.model_validate_json(json.dumps(node["parameters"]), strict=True)
        inputs, outputs = tuple(component.inputs(parameters)), tuple(component.outputs(parameters))
    except (ValueError, TowlineError) as error:
        raise AssignmentError(f"{name}: {error}") from error
    for kind, here, there in (("inputs", inputs, node["inputs"]), ("outputs", outputs, node["outputs"])):
        if _ports_to_json(here) != there:
            raise AssignmentError(f"{name}: {_port_difference(model, kind, _ports_to_json(here), there)}")
    return Node(
        name=name,
        model=model,
        component=component,
        parameters=parameters,
        seed=node["seed"],
        period=node["period"],
        record_every=0,
        inputs=inputs,
        outputs=outputs,
        start=node["start"],
        terms=tuple(_term(term) for term in node["terms"]),
    )


def _port_difference(model: str, kind: str, here: list[list[Any]], there: list[list[Any]]) -> str:
    lacking = [port for port in there if port not in here] or there
    other = [port for port in here if port not in there] or here
    return f"{model} has other {kind} here: {_shown(other)}, and at the conductor {_shown(lacking)}"


def _shown(ports: list[list[Any]]) -> str:
    return ", ".join(f"{name} {shape or ''} [{unit}]".replace("  ", " ") for name, unit, shape, *_ in ports) or "none"


def _local_file(model: str, file_hash: str) -> str:
    """A file model's path on this machine: the conductor's, or a file of that name in the working folder."""
    if not file_hash:
        return model
    places = [path for path in (Path(model), Path.cwd() / Path(model).name) if path.is_file()]
    for path in places:
        if _file_hash(path) == file_hash:
            return str(path)
    if places:
        raise ValueError(f"{places[0]} differs from the conductor's {model}; copy that here")
    raise ValueError(f"there is no {model} here; copy it to {Path.cwd()}: code does not travel over the bus")


def _term(term: dict[str, Any]) -> Term:
    return Term(**{**term, "offset": tuple(term["offset"]), "initial": tuple(term["initial"])})


def _bond(bond: dict[str, Any]) -> Bond:
    return Bond(**{**bond, "other": OtherEnd(**bond["other"]) if bond["other"] else None})
