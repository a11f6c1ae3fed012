"""Building an FMU: machine code and C sources into a shared library, that and its description into an archive."""

from __future__ import annotations

import functools
import hashlib
import io
import re
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

from components.contract import Component, Parameters
from pipeline.errors import TowlineError
from pipeline.fmu.description import Experiment, description
from pipeline.fmu.instance import Instance
from pipeline.fmu.machine_code import object_code
from pipeline.fmu.platforms import folder_here
from pipeline.fmu.source import model
from pipeline.fmu.variables import Contents, Variable, contents, elements, independent

SOURCES = Path(__file__).parent / "native"
SHARED = ("core.c", "values.c", "saved.c")
OF_STANDARD = {2: ("fmi2.c",), 3: ("fmi3.c", "fmi3_refused.c")}
COMPILERS = ("cc", "gcc", "clang")
# No fused multiply-add, which rounds once where the native run rounds twice; no symbol left to the host.
FLAGS = ("-std=c11", "-O1", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-w")
LINKING = ("-shared", "-Wl,-z,defs", "-Wl,-z,noexecstack", "-Wl,--build-id=none", "-s", "-lm")
COMPILING_S = 120  # far above the second or two that it takes
EPOCH = (1980, 1, 1, 0, 0, 0)  # of the archive's members, so that the same component gives the same file


def build(of: Instance, fmi: int) -> bytes:
    """The archive of an FMI 2.0 or 3.0 co-simulation FMU. Raises TowlineError."""
    component, step_ns = of.component, of.step_ns
    experiment = Experiment(step_ns, of.start_ns, has_bond(component, of.parameters))
    found = contents(component, of.parameters, of.seed, of.inputs)
    variables = elements(found.variables) if fmi == 2 else (independent(found.variables), *found.variables)
    _check_names(variables)
    identifier = re.sub(r"\W", "_", component.name, flags=re.ASCII)
    code = object_code(component)
    token = _token(fmi, code, found, variables, experiment)
    library = _library(fmi, code, model(found, variables, token, step_ns, experiment.step_is_fixed))
    document = description(fmi, found, variables, token, identifier, experiment)
    return _archive({"modelDescription.xml": document, f"binaries/{folder_here(fmi)}/{identifier}.so": library})


def has_bond(component: Component, parameters: Parameters) -> bool:
    """Whether an end gives or takes a law of force, which is made for the next step to be as long as the last."""
    ends = (*component.bodies.values(), *component.lines.values())
    return any(not end.switch or bool(getattr(parameters, end.switch)) for end in ends)


def _check_names(variables: tuple[Variable, ...]) -> None:
    names = [one.name for one in variables]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TowlineError(f"an FMU would have two variables named '{twice[0]}'; rename the port")


def _token(fmi: int, code: bytes, found: Contents, variables: tuple[Variable, ...], experiment: Experiment) -> str:
    """What description and binary know each other by: a hash of all that the FMU is made of."""
    digest = hashlib.sha256(code)
    for path in sorted(SOURCES.iterdir()):
        digest.update(path.read_bytes())
    p = found.component.pack(found.parameters, found.seed)
    digest.update(f"{fmi} {variables} {found.formulas} {experiment}".encode() + p.tobytes())
    text = digest.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def _compiler() -> str:
    for name in COMPILERS:
        if path := shutil.which(name):
            return path
    remedy = "install one, e.g. apt-get install gcc libc6-dev"
    raise TowlineError(f"no C compiler found ({', '.join(COMPILERS)}), which links the FMU's library; {remedy}")


def _library(fmi: int, code: bytes, source: str) -> bytes:
    with tempfile.TemporaryDirectory(prefix="towline-fmu-") as name:
        folder = Path(name)
        (folder / "kernels.o").write_bytes(code)
        (folder / "model.c").write_text(source)
        for shared, content in _shared_code(fmi).items():
            (folder / shared).write_bytes(content)
        _run(folder, "model.c", "kernels.o", *_shared_code(fmi), *LINKING, "-o", "library.so")
        return (folder / "library.so").read_bytes()


@functools.cache
def _shared_code(fmi: int) -> dict[str, bytes]:
    """The object files of native/, which are the same for each model, by name."""
    with tempfile.TemporaryDirectory(prefix="towline-fmu-") as name:
        _run(Path(name), "-c", *(str(SOURCES / source) for source in (*SHARED, *OF_STANDARD[fmi])))
        return {path.name: path.read_bytes() for path in sorted(Path(name).iterdir())}


def _run(folder: Path, *words: str) -> None:
    """The C compiler in a folder. Raises TowlineError."""
    compiler = _compiler()
    try:
        done = subprocess.run(
            [compiler, *FLAGS, f"-I{SOURCES}", *words], cwd=folder, capture_output=True, text=True, timeout=COMPILING_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise TowlineError(f"{compiler} did not link the FMU's library: {error}") from error
    if done.returncode != 0:
        raise TowlineError(f"{compiler} did not link the FMU's library: {_first_error(done.stderr)}")


def _first_error(text: str) -> str:
    lines = [line for line in text.splitlines() if "error" in line or "undefined" in line]
    return (lines or text.splitlines() or ["it said nothing"])[0][:300]


def _archive(files: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            about = zipfile.ZipInfo(name, EPOCH)
            about.compress_type = zipfile.ZIP_DEFLATED
            about.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            archive.writestr(about, content)
    return out.getvalue()
