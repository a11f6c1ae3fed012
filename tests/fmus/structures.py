"""System structures in tests: written, converted, compared."""

from __future__ import annotations

import json
from pathlib import Path

import fmpy
import numpy as np
import yaml
from lxml import etree

from pipeline.cli import main
from pipeline.conductor import Conductor
from pipeline.graph import Graph
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
SSP = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = f'xmlns:ssd="{SSP}Description" xmlns:ssc="{SSP}Common" xmlns:ssv="{SSP}ParameterValues" '
SPACES += f'xmlns:ssm="{SSP}ParameterMapping"'
STOP = '<ssd:DefaultExperiment startTime="0" stopTime="2.5"/>'


def convert(capsys, *words: str) -> list[str]:
    """Convert, and give what was not kept."""
    code = main(["convert", *words, "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 0, told
    return told["notes"]


def refusal(capsys, *words: str) -> str:
    assert main(["convert", *words]) == 1
    return capsys.readouterr().err


def graph_of(path: str) -> Graph:
    return build_graph(load_scenario(path))


def compared(graph: Graph) -> list:
    """All of a graph that a run depends on."""
    nodes = [
        (n.name, n.period, n.record_every, n.seed, n.terms, n.component.interface, n.component.isolate)
        for n in graph.nodes
    ]
    fed = [{port.name for port in n.inputs} for n in graph.nodes]  # whose start values come to the same as constants
    values = [n.parameters.model_dump(exclude=names) for n, names in zip(graph.nodes, fed, strict=True)]
    return [graph.base_ns, graph.ticks, graph.start_ns, graph.stages, graph.events, nodes, values]


def ran(graph: Graph) -> dict[str, np.ndarray]:
    """What the board holds at the end of a run, by component."""
    conductor = Conductor(graph)
    try:
        conductor.initialise()
        for _ in conductor.run(graph.ticks):
            pass
        memory = conductor.memory
        return {node.name: memory.tables.board[memory.spans["y"][i]].copy() for i, node in enumerate(graph.nodes)}
    finally:
        conductor.close()


def ssd(elements: str, connections: str = "", more: str = "", outer: str = "", units: str = "") -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {SPACES} version="1.0" name="plant">'
        f'<ssd:System name="plant">{outer}<ssd:Elements>{elements}</ssd:Elements>'
        + (f"<ssd:Connections>{connections}</ssd:Connections>" if connections else "")
        + f"</ssd:System>{units}{more}</ssd:SystemStructureDescription>"
    )


def component(name: str, fmu: str, inside: str = "") -> str:
    return (
        f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="{fmu}">{inside}</ssd:Component>'
    )


def wire(start: str, end: str, inside: str = "", more: str = "") -> str:
    """A connection; `.x`: of the system itself."""
    names = {}
    for key, (element, _, connector) in (("start", start.partition(".")), ("end", end.partition("."))):
        names |= {f"{key}Connector": connector} | ({f"{key}Element": element} if element else {})
    attributes = " ".join(f'{key}="{value}"' for key, value in names.items())
    return (
        f"<ssd:Connection {attributes} {more}>{inside}</ssd:Connection>"
        if inside
        else f"<ssd:Connection {attributes} {more}/>"
    )


def values(*parameters: str, prefix: str = "", units: str = "") -> str:
    listed = "".join(parameters)
    return (
        f'<ssd:ParameterBindings><ssd:ParameterBinding prefix="{prefix}"><ssd:ParameterValues>'
        '<ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>'
        f"{listed}</ssv:Parameters>{units}</ssv:ParameterSet></ssd:ParameterValues>"
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def value(name: str, kind: str, text: str, unit: str = "") -> str:
    return (
        f'<ssv:Parameter name="{name}"><ssv:{kind} value="{text}"{f" unit={unit!r}" if unit else ""}/></ssv:Parameter>'
    )


def linear(factor: float | str, offset: float = 0.0) -> str:
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def read(capsys, document: str, name: str = "plant.ssd", *words: str) -> tuple[dict, list[str]]:
    """The scenario of a document that is valid by the schema, and what was not kept."""
    if name.endswith(".ssd"):
        etree.XMLSchema(file=str(SCHEMAS / "SystemStructureDescription.xsd")).assertValid(
            etree.fromstring(document.encode())
        )
    Path(name).write_text(document)
    notes = convert(capsys, name, "-o", "read.yaml", "--overwrite", *words)
    graph_of("read.yaml")
    return yaml.safe_load(Path("read.yaml").read_text()), notes
