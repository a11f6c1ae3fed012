"""The few errors a user can meet; each message is one line with place and remedy."""

from __future__ import annotations

from dataclasses import dataclass


class TowlineError(Exception):
    """Something the user can mend: shown as its message alone, without a traceback."""


@dataclass(frozen=True, order=True)
class Place:
    """Where in a YAML file something stands, line and column counted from 1; or an option of the command line."""

    file: str
    line: int = 1
    column: int = 1

    def __str__(self) -> str:
        return self.file if self.file.startswith("--") else f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Problem:
    """One thing wrong at one place: `file:line:col path: what is wrong, what would be right`."""

    place: Place
    path: str
    text: str

    def __str__(self) -> str:
        return f"{self.place} {self.path}: {self.text}" if self.path else f"{self.place} {self.text}"


class ProblemsError(TowlineError):
    """All problems of one file together, one a line, in the order they stand."""

    def __init__(self, problems: list[Problem]):
        self.problems = sorted(problems, key=lambda problem: (problem.place, problem.path))
        super().__init__("\n".join(str(problem) for problem in self.problems))


class ScenarioError(ProblemsError):
    """The YAML itself is wrong: syntax, keys, values, units of parameters, files."""


class WiringError(ProblemsError):
    """The components do not fit together: ports, shapes, units, frames, rates, cycles."""


class StepError(TowlineError):
    """A component stopped the run: bad status or non-finite output; names component, port, time and inputs."""


class HostError(StepError):
    """A host of a distributed run refused, died again and again, or stayed away; names host, component and step."""


class LogError(TowlineError):
    """A log cannot be read, written, resumed or replayed."""
