"""towline fmu: build an FMU from a component, and tell what an FMU of anyone's contains."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from rich.table import Table

from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError
from pipeline.fmu.information import Information, information
from pipeline.quantities import nanoseconds

SHOWN = 60  # variables of one role that a person is shown; --json gives all


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    text = "export a component as an FMU that needs no Python"
    making = actions.add_parser("build", help=text, description=f"{text[0].upper()}{text[1:]}.")
    making.add_argument("model", help="tether.cable, ./own.py, or scenario.yaml#component with its parameters there")
    making.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter, with its unit or in SI; file=P.yaml: a file of parameters",
    )
    making.add_argument("--out", "-o", type=Path, metavar="F", help="the FMU (default: MODEL.fmu)")
    making.add_argument("--fmi", type=int, choices=(2, 3), default=2, help="version of the standard (default: 2)")
    making.add_argument("--step", metavar="TIME", help="step it is initialised for (default: 10 ms, or the scenario's)")
    making.add_argument("--seed", type=int, metavar="N", help="of its random numbers (default: 0, or the scenario's)")
    telling = actions.add_parser("info", help="print an FMU's ports, units and capabilities")
    telling.add_argument("fmu", type=Path, help="an FMU")
    for action in (making, telling):
        action.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
        action.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)


def command(arguments: argparse.Namespace) -> int:
    """Do what is asked for."""
    return _build(arguments) if arguments.action == "build" else _info(arguments)


def _build(arguments: argparse.Namespace) -> int:
    from pipeline.fmu.build import build  # with numba, which telling does without
    from pipeline.fmu.instance import instance

    chosen = instance(arguments.model, arguments.param)
    step_ns = chosen.step_ns if arguments.step is None else _step(arguments.step)
    seed = chosen.seed if arguments.seed is None else arguments.seed
    if not 0 <= seed < 2**64:
        raise TowlineError(f"--seed: {seed}; expected a whole number from 0 to 2^64 - 1")
    out = arguments.out or Path(f"{chosen.component.name}.fmu")
    archive = build(replace(chosen, seed=seed, step_ns=step_ns), arguments.fmi)
    try:
        out.write_bytes(archive)
    except OSError as error:
        raise TowlineError(f"{out}: cannot be written: {error.strerror}") from error
    told = information(out)
    if arguments.json:
        print_json({"fmu": str(out), "fmi": told.fmi, "bytes": len(archive), "model": told.model})
    else:
        console().print(f"{out}: {told.model} as FMI {told.fmi}, {len(archive) / 1e3:.0f} kB; towline fmu info {out}")
    return 0


def _step(text: str) -> int:
    try:
        step_ns = nanoseconds(text, bare=True)
    except ValueError as error:
        raise TowlineError(f"--step: {error}") from error
    if step_ns <= 0:
        raise TowlineError(f"--step: '{text}' is not above zero; expected e.g. '10 ms'")
    return step_ns


def _info(arguments: argparse.Namespace) -> int:
    told = information(arguments.fmu)
    if arguments.json:
        print_json(told)
        return 0
    out = console()
    out.print(f"{arguments.fmu}: {told.model}, FMI {told.fmi} ({', '.join(told.interfaces)}), by {told.tool or '?'}")
    if told.description:
        out.print(told.description)
    out.print(f"platforms: {', '.join(told.platforms) or 'none'}; step: {_seconds(told.step_s)}")
    _print_variables(told)
    _print_capabilities(told)
    return 0


def _seconds(step_s: float | None) -> str:
    return "any" if step_s is None else f"{step_s:g} s"


def _print_variables(told: Information) -> None:
    table = Table()
    for column in ("variable", "role", "type", "unit", "shape", "start", "description"):
        table.add_column(column)
    for role in dict.fromkeys(one.role for one in told.variables):
        members = [one for one in told.variables if one.role == role]
        for one in members[:SHOWN]:
            shape = " x ".join(map(str, one.shape))
            table.add_row(one.name, one.role, one.type, one.unit, shape, _shortened(one.start), one.description)
        if len(members) > SHOWN:
            table.add_row(f"... and {len(members) - SHOWN} more", role, "", "", "", "", "--json gives all")
    console().print(table)


def _shortened(start: str) -> str:
    return start if len(start) <= 24 else f"{start[:21]}..."


def _print_capabilities(told: Information) -> None:
    table = Table()
    for column in ("capability", *told.interfaces):
        table.add_column(column)
    for name in dict.fromkeys(name for found in told.capabilities.values() for name in found):
        table.add_row(name, *(told.capabilities[kind].get(name, "") for kind in told.interfaces))
    console().print(table)
