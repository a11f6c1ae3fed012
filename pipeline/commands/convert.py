"""towline convert: a system structure of another tool's into a scenario, and a scenario of FMUs into an SSP."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.commands.output import console, print_json, warn
from pipeline.errors import TowlineError
from pipeline.quantities import nanoseconds

if TYPE_CHECKING:
    from pipeline.ssp.system import System

FROM = "SYSTEM.ssp, an SSD (.ssd) or an OspSystemStructure.xml; or a scenario YAML of FMUs"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("source", type=Path, help=FROM)
    parser.add_argument("--out", "-o", type=Path, metavar="F", help="scenario YAML, or the SSP (default: beside it)")
    parser.add_argument("--overwrite", action="store_true", help="replace what is there")
    parser.add_argument("--step", metavar="TIME", help="base step of the scenario (default: as the system says)")
    parser.add_argument(
        "--duration", metavar="TIME", help="simulated time of the scenario (default: as the system says)"
    )
    help_text = "of the scenario: direct where they close no cycle, or all delayed (default: SSP direct, OSP delayed)"
    parser.add_argument("--wires", choices=("direct", "delayed"), help=help_text)


def command(arguments: argparse.Namespace) -> int:
    """Convert it."""
    source: Path = arguments.source
    is_scenario = source.suffix.lower() in (".yaml", ".yml")
    out = arguments.out or source.with_suffix(".ssp" if is_scenario else ".yaml")
    if out.exists() and not arguments.overwrite:
        raise TowlineError(f"{out} exists; give another --out, or --overwrite")
    if (out.suffix.lower() == ".ssp") != is_scenario:
        raise TowlineError(f"{out}: a scenario is converted to an .ssp, and {FROM.partition(';')[0]} to a .yaml")
    notes = _write_ssp(source, out) if is_scenario else _write_scenario(arguments, out)
    for text in notes:
        warn(text)
    checked = "" if is_scenario else _checked(out)
    if arguments.json:
        print_json({"out": str(out), "notes": notes})
    else:
        console().print(f"{out}{checked}")
    return 0


def _write_ssp(source: Path, out: Path) -> list[str]:
    from pipeline.scenario import load_scenario
    from pipeline.ssp.export import ssp
    from pipeline.wiring import build_graph

    scenario = load_scenario(source)
    content, notes = ssp(scenario, build_graph(scenario))
    _write(out, content)
    return notes


def _write_scenario(arguments: argparse.Namespace, out: Path) -> list[str]:
    from pipeline.ssp import osp, ssd
    from pipeline.ssp.package import copied, opened
    from pipeline.ssp.scenario_text import relative, scenario_text

    step_ns, duration_ns = _time(arguments.step, "--step"), _time(arguments.duration, "--duration")
    is_delayed = None if arguments.wires is None else arguments.wires == "delayed"
    with opened(arguments.source) as (package, root):
        kind = str(root.tag).rpartition("}")[2]
        if kind == osp.ROOT:
            system = osp.read(package, root)
        elif kind == "SystemStructureDescription":
            system = ssd.read(package, root)
        else:
            raise TowlineError(f"{arguments.source}: its root is {kind}; expected an SSD or an {osp.ROOT}")
        if package.is_closed:
            folder = out.with_name(f"{out.stem}_fmus")
            if folder.exists() and not arguments.overwrite:
                raise TowlineError(f"{folder} exists, where the FMUs would go; give another --out, or --overwrite")
            names = _copies(package.folder, _fmus(system))
            written = {path: f"{folder.name}/{name}" for path, name in names.items()}
            text = scenario_text(system, written, step_ns, duration_ns, is_delayed)
            copied(names, folder)
        else:
            written = {path: relative(path, out.parent) for path in _fmus(system)}
            text = scenario_text(system, written, step_ns, duration_ns, is_delayed)
    _write(out, text.encode())
    return system.notes


def _fmus(system: System) -> list[Path]:
    return list(dict.fromkeys(part.fmu for part in system.parts))


def _copies(folder: Path, fmus: list[Path]) -> dict[Path, str]:
    """Names for files of a package in one folder."""
    plain = {path: path.name for path in fmus}
    if len(set(plain.values())) == len(fmus):
        return plain
    return {path: path.resolve().relative_to(folder.resolve()).as_posix().replace("/", "_") for path in fmus}


def _checked(out: Path) -> str:
    """What to do with the scenario. Raises ScenarioError or WiringError where it does not run as it is."""
    from pipeline.scenario import load_scenario
    from pipeline.wiring import build_graph

    graph = build_graph(load_scenario(out))
    return f": {len(graph.nodes)} FMUs; towline run {out}"


def _time(text: str | None, option: str) -> int | None:
    if text is None:
        return None
    try:
        time_ns = nanoseconds(text, bare=True)
    except ValueError as error:
        raise TowlineError(f"{option}: {error}") from error
    if time_ns <= 0:
        raise TowlineError(f"{option}: '{text}' is not above zero; expected e.g. '10 ms'")
    return time_ns


def _write(out: Path, content: bytes) -> None:
    try:
        out.write_bytes(content)
    except OSError as error:
        raise TowlineError(f"{out}: cannot be written: {error.strerror}") from error
