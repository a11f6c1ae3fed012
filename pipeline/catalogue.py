"""Finding a component by the model name written in a scenario."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import re
import sys
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType

import components
from components.contract import Component, Parameters
from pipeline.kernels import fault
from pipeline.quantities import shown

_NEAR = 0.6  # difflib's own measure of a close match
_ROOT = Path(components.__file__).parent
_MODEL = re.compile(r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*")


def closest(name: str, names: list[str] | tuple[str, ...], what: str = "one of") -> str:
    """The end of a message about an unknown name: `; did you mean 'length'?`, or the names there are."""
    if near := get_close_matches(name[:100], names, 1, _NEAR):
        return f"; did you mean '{near[0]}'?"
    if not names:
        return "; there are none"
    return f"; expected {what} {', '.join(names[:12])}{', ...' if len(names) > 12 else ''}"


def meant(names: Iterable[str], candidates: Iterable[str]) -> frozenset[str]:
    """Those of the candidates that one of the unknown names is probably a misspelling of."""
    known = list(candidates)
    return frozenset(near for name in names for near in get_close_matches(name[:100], known, 1, _NEAR))


def models() -> list[str]:
    """Names of all models in components/: `motion.hand`, `tether.cable`, ..."""
    return sorted(".".join(path.relative_to(_ROOT).parts[:-1]) for path in _ROOT.glob("*/*/component.py"))


def find(model: str, folder: Path) -> tuple[str, Component]:
    """The component of `motion.hand`, or of `./my_component.py` beside the scenario in `folder`, and its full name.

    A file's full name is its absolute path. Raises ValueError with what is wrong and what would be right.
    """
    if model.endswith(".py"):
        path = _absolute(folder, model)
        return str(path), _component_of(_load_file(path), model)
    names = models()
    if not _MODEL.fullmatch(model) or model not in names:
        raise ValueError(f"unknown model {shown(model)}{closest(model, names)}")
    return model, _component_of(_import(model), model)


def _absolute(folder: Path, model: str) -> Path:
    try:
        path = (folder / model).resolve()
        is_file = path.is_file()
    except (OSError, ValueError, RuntimeError):
        is_file = False
    if not is_file:
        raise ValueError(f"no such file '{model}' in {folder}; expected a Python file with a COMPONENT")
    return path


def _import(model: str) -> ModuleType:
    try:
        return importlib.import_module(f"components.{model}.component")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # SystemExit among them
        raise ValueError(f"model '{model}' cannot be loaded: {first_line(error)}") from error


def _load_file(path: Path) -> ModuleType:
    """The module of a file, loaded once for each content; numba's cache finds it in sys.modules by name."""
    name = f"towline_model_{path.stem}_{hashlib.sha256(str(path).encode() + path.read_bytes()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"'{path.name}' is no Python module")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException as error:  # SystemExit among them
        del sys.modules[name]
        if isinstance(error, KeyboardInterrupt):
            raise
        raise ValueError(f"'{path.name}' cannot be loaded: {first_line(error)}") from error
    return module


def _component_of(module: ModuleType, model: str) -> Component:
    component = getattr(module, "COMPONENT", None)
    if not isinstance(component, Component):
        raise ValueError(f"'{model}' has no COMPONENT; expected one made by components.contract.Component")
    if not isinstance(component.name, str) or not _is_parameters(component.parameters):
        raise ValueError(f"'{model}' has a COMPONENT whose name is no text or whose parameters are no Parameters class")
    if wrong := fault(component):
        raise ValueError(f"'{model}': {wrong}")
    return component


def _is_parameters(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Parameters)


def first_line(error: BaseException) -> str:
    """An exception as one line: `KeyError: 'mass'`; a ValueError's text speaks for itself."""
    lines = str(error).splitlines()
    if type(error) is ValueError and lines:
        return lines[0][:200]
    return f"{type(error).__name__}: {lines[0][:200]}" if lines else type(error).__name__
