"""What the tests export: a component of a scenario for each compiled model, or the model with some parameters."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

from components.contract import SEED_HIGH
from pipeline import catalogue
from pipeline.graph import Graph
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
# Not those that are made of FMUs, which would be built as the tests are collected.
SCENARIOS = sorted(path.name for path in (ROOT / "scenarios").glob("*.yaml") if "fmu: " not in path.read_text())

# What a model that no scenario has asks for beside its parameters without a default.
ALSO = {"tether.catenary": ["weight=0.9 N/m"]}


@cache
def scene(name: str) -> Graph:
    return build_graph(load_scenario(ROOT / "scenarios" / name))


def distinct() -> list[tuple[str, int]]:
    """Of each model of the scenarios, its specimen for FMI 2 and 3, and the instance with the most numbers for one.

    As `scenario.yaml#component`, and the version of FMI.
    """
    largest: dict[str, tuple[float, str]] = {}
    for name in SCENARIOS:
        for node in scene(name).nodes:
            numbers = float(sum(node.component.pack(node.parameters)[:SEED_HIGH]))
            if node.component.compiled and numbers > largest.get(node.model, (0.0, ""))[0]:
                largest[node.model] = numbers, f"{name}#{node.name}"
    first = {model: specimen(model)[0] for model in largest}
    both = [(text, fmi) for text in first.values() for fmi in (2, 3)]
    more = [text for model, (_, text) in largest.items() if text != first[model]]
    return both + [(text, 2 + i % 2) for i, text in enumerate(more)]


@cache
def specimen(model: str) -> tuple[str, list[str]]:
    """How a model is exported: a component of a scenario, or the model with parameters."""
    for name in SCENARIOS:
        for node in scene(name).nodes:
            if node.model == model:
                return f"{name}#{node.name}", []
    schema = catalogue.find(model, ROOT)[1].parameters.model_json_schema()
    lacking = schema.get("required", [])
    kinds = schema.get("$defs", {})
    written = [f"{name}={json.dumps(any_value(schema['properties'][name], kinds))}" for name in lacking]
    return model, written + ALSO.get(model, [])


def any_value(schema: dict, kinds: dict) -> object:
    """Some value that a JSON schema allows, for a parameter without a default; kinds: of mappings of parameters."""
    if "$ref" in schema:
        kind = kinds[schema["$ref"].rpartition("/")[2]]
        return {name: any_value(kind["properties"][name], kinds) for name in kind.get("required", [])}
    match schema.get("type"):
        case "number":
            return 1.0 + schema.get("exclusiveMinimum", schema.get("minimum", 0.0))
        case "integer":
            return 3 + schema.get("minimum", 0)
        case "array":
            items = schema.get("prefixItems") or [schema["items"]] * max(2, schema.get("minItems", 0))
            return [any_value(item, kinds) for item in items]
        case "boolean":
            return False
    return schema["enum"][0]


def compiled_models() -> list[str]:
    return [model for model in catalogue.models() if catalogue.find(model, ROOT)[1].compiled]
