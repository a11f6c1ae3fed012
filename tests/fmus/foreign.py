"""FMUs that this project did not export: C sources of this folder, compiled and packed as the tests ask for them."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
from description import Model, Variable, described, token

HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
FLAGS = ("-std=gnu11", "-O1", "-ffp-contract=off", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror")
COMPILING_S = 60
STATE = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
EVENTS = {"hasEventMode": "true", "mightReturnEarlyFromDoStep": "true"}

VAN_DER_POL = Model(
    "van_der_pol",
    (
        Variable("x", 0, "output", start=2.0, unit="m", description="position"),
        Variable("v", 1, "output", start=0.0, unit="m/s"),
        Variable("der(x)", 5, "local", unit="m/s", of="x"),
        Variable("der(v)", 6, "local", unit="m/s2", of="v"),
        Variable("mu", 2, "parameter", start=1.0, variability="tunable"),
        Variable("coupling", 3, "parameter", start=0.0),
        Variable("neighbour", 4, "input", start=0.0, unit="m"),
    ),
    flags=STATE,
)
BALL = Model(
    "ball",
    (
        Variable("h", 0, "output", start=1.0, unit="m", description="height above ground"),
        Variable("v", 1, "output", start=0.0, unit="m/s"),
        Variable("der(h)", 5, "local", unit="m/s", of="h"),
        Variable("der(v)", 6, "local", unit="m/s2", of="v"),
        Variable("z", 7, "local", unit="m"),
        Variable("g", 2, "parameter", start=9.81, unit="m/s2"),
        Variable("e", 3, "parameter", start=0.7, variability="tunable"),
        Variable("least", 4, "parameter", start=0.1, unit="m/s"),
        Variable("bounces", 1000, "output", "Int32"),
    ),
    indicators=("z",),
    flags=STATE | EVENTS,
)
STAIR = Model(
    "stair",
    (
        Variable("level", 1000, "output", "Int32"),
        Variable("last", 1001, "parameter", "Int32", start=1000),
        Variable("interval", 0, "parameter", start=0.25, unit="s"),
    ),
    flags=EVENTS,
)
WIDTHS = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
KINDS = Model(
    "kinds",
    (
        Variable("real_in", 0, "input", start=0.0, unit="kN"),
        Variable("real_out", 1, "output", unit="kN"),
        Variable("gain", 2, "parameter", start=1.0),
        Variable("offset", 3, "parameter", start=0.0, unit="kN", variability="tunable"),
        Variable("int_in", 1000, "input", "Int32", start=0),
        Variable("int_out", 1001, "output", "Int32"),
        Variable("count", 1002, "parameter", "Int32", start=0),
        Variable("choice_in", 1003, "input", "Enumeration", start=1),
        Variable("choice_out", 1004, "output", "Enumeration"),
        Variable("choice", 1005, "parameter", "Enumeration", start=1),
        Variable("text_length", 1006, "output", "Int32"),
        Variable("on_in", 2000, "input", "Boolean", start=False),
        Variable("on_out", 2001, "output", "Boolean"),
        Variable("on", 2002, "parameter", "Boolean", start=False),
        Variable("name", 3000, "parameter", "String", start="none"),
    ),
    ("CoSimulation",),
)
TEXTS = Model(  # with texts that change, which no port can carry
    "kinds",
    (
        *KINDS.variables,
        Variable("text_out", 3001, "output", "String"),
        Variable("text_in", 3002, "input", "String", start=""),
    ),
    ("CoSimulation",),
)
ALL_KINDS = Model(  # FMI 3 only
    "kinds",
    (
        *KINDS.variables,
        Variable("short_in", 4, "input", "Float32", start=0.0),
        Variable("short_out", 5, "output", "Float32"),
        Variable("byte_sum", 1007, "output", "Int32"),
        Variable("large", 1008, "parameter", "Int64", start=0),
        Variable("large_out", 1009, "output", "Int64"),
        *(Variable(f"{kind.lower()}_in", 1010 + k, "input", kind, start=0) for k, kind in enumerate(WIDTHS)),
        *(Variable(f"{kind.lower()}_out", 1020 + k, "output", kind) for k, kind in enumerate(WIDTHS)),
        Variable("blob", 4000, "parameter", "Binary", start="00ff"),
    ),
    ("CoSimulation",),
)
ARRAYS = Model(
    "arrays",
    (
        Variable("n", 1000, "structuralParameter", "UInt64", start=2),
        Variable("u", 0, "input", start=(0.0, 0.0), unit="m", shape=("n",)),
        Variable("y", 16, "output", unit="m", shape=("n",)),
        Variable("A", 32, "parameter", start=(1.0, 0.0, 0.0, 1.0), shape=("n", "n")),
        Variable("f", 300, "output", unit="m", shape=(2, 3)),
        Variable("arm.tip.x", 320, "output", unit="m"),
        Variable("arm.span", 321, "parameter", start=0.0, unit="m"),
    ),
    ("CoSimulation",),
)
BAD = Model(
    "bad",
    (
        Variable("y", 0, "output", unit="s"),
        Variable("at", 1, "parameter", start=0.0, unit="s"),
        Variable("largest", 2, "parameter", start=1.0, unit="s"),
        Variable("u", 3, "input", start=0.0),
        Variable("mode", 1000, "parameter", "Int32", start=0),
        Variable("where", 1001, "parameter", "Int32", start=0),
    ),
    ("CoSimulation",),
)
# The values of bad.c's parameters `mode` and `where`.
MODES = (
    "fine",
    "warns",
    "discards",
    "fails",
    "is_fatal",
    "crashes",
    "aborts",
    "exits",
    "sleeps",
    "spins",
    "not_finite",
    "logs",
    "no_status",
    "short_steps",
    "killed",
    "overflows",
    "noisy",
)
PLACES = ("step", "start", "after_start", "get", "set", "terminate", "free")


class ForeignFmus:
    """Builds each FMU once."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._made: dict[object, Path] = {}

    def __call__(
        self,
        model: Model,
        fmi: int = 2,
        *defines: str,
        edit: Callable[[str], str] | None = None,
        files: dict[str, bytes] | None = None,
    ) -> Path:
        """The FMU.

        defines: of the C source, or flags of the compiler. edit: makes its description lie. files: more in the archive.
        """
        key = (repr(model), fmi, defines)
        if edit is None and files is None and key in self._made:
            return self._made[key]
        document = described(model, fmi)
        if edit is not None:
            honest, document = document, edit(document)
            assert document != honest
        path = self._folder / f"{model.name}_{fmi}_{len(self._made)}.fmu"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
            out.writestr("modelDescription.xml", document)
            place = "x86_64-linux" if fmi == 3 else "linux64"
            out.write(self.library(model.name, fmi, *defines), f"binaries/{place}/{model.name}.so")
            for name, content in (files or {}).items():
                out.writestr(name, content)
        self._made[key if edit is None and files is None else object()] = path
        return path

    def library(self, name: str, fmi: int, *defines: str) -> Path:
        """The shared library of a model's C source."""
        key = (name, fmi, defines)
        if key not in self._made:
            path = self._folder / f"{name}_{fmi}_{len(self._made)}.so"
            words = ["gcc", *FLAGS, f"-I{HEADERS}", f"-I{HERE}", f"-DPREFIX={name}", f'-DMODEL_TOKEN="{token(name)}"']
            sources = [str(HERE / source) for source in (f"{name}.c", "core.c", f"fmi{fmi}.c")]
            words += [
                *(one if one.startswith("-") else f"-D{one}" for one in defines),
                *sources,
                "-lm",
                "-o",
                str(path),
            ]
            subprocess.run(words, check=True, capture_output=True, text=True, timeout=COMPILING_S)
            self._made[key] = path
        return self._made[key]
