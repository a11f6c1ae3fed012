"""What a log says of where its numbers come from: versions, sources, file models and FMUs."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from components import cache
from pipeline.graph import Graph
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.description import Description
from pipeline.scenario import Scenario

RUN = "run"  # the log's metadata record of it
MODELS_HASH, FMUS = "models_hash", "fmus"  # in RUN; the second is JSON: {path: SHA-256}
ATTACHED_BYTES = 16 << 20  # FMUs up to this size are put into the log
PACKAGES = ("numpy", "numba", "llvmlite", "mcap", "protobuf", "opencv-python-headless")


def provenance(scenario: Scenario, graph: Graph, block: int) -> dict[str, str]:
    """What the numbers depend on beside the scenario."""
    here = {"python": platform.python_version(), "machine": platform.machine()}
    sources = {"source_hash": cache.source_hash(), MODELS_HASH: models_hash(model_files(graph))}
    sources[FMUS] = json.dumps({str(one.path): one.digest for one in fmus(graph)})
    times = {"base_ns": str(graph.base_ns), "start_ns": str(graph.start_ns), "block_ticks": str(block)}
    return {"scenario": scenario.name, **versions(), **here, **sources, **times}


@functools.cache
def versions() -> dict[str, str]:
    """Of the packages. Raises PackageNotFoundError where one is not installed."""
    return {package: version(package) for package in ("towline", *PACKAGES)}


def model_files(graph: Graph) -> dict[str, bytes]:
    """Sources of the components that come from files beside the scenario, by the path which the graph names."""
    return {node.model: Path(node.model).read_bytes() for node in graph.nodes if node.model.endswith(".py")}


def fmus(graph: Graph) -> list[Description]:
    """The FMUs of the components, each once."""
    found = [node.component.description for node in graph.nodes if isinstance(node.component, FmuComponent)]
    return list(dict.fromkeys(found))


def small_fmus(graph: Graph) -> dict[str, bytes]:
    """The files that a log takes along, by path."""
    return {str(one.path): one.path.read_bytes() for one in fmus(graph) if one.path.stat().st_size <= ATTACHED_BYTES}


def models_hash(files: Mapping[str, bytes]) -> str:
    """SHA-256 over the sources of file models, wherever they lie; empty if there are none."""
    digest = hashlib.sha256()
    for path, text in sorted(files.items(), key=lambda item: Path(item[0]).name):
        digest.update(Path(path).name.encode() + b"\0" + text + b"\0")
    return digest.hexdigest() if files else ""
