"""The layout's rules that import-linter cannot say, checked on the sources themselves."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted([*(ROOT / "components").rglob("*.py"), *(ROOT / "pipeline").rglob("*.py")])
COMPONENT_FILES = [p for p in SOURCES if p.is_relative_to(ROOT / "components") and len(p.relative_to(ROOT).parts) == 4]
BORDER = ("model.py", "component.py")
ALSO = {"camera": {"cv2"}, "vision": {"cv2"}}  # images
PHYSICS_MAY_IMPORT = {"numpy", "numba", "components", *sys.stdlib_module_names}
# A family may use the physics of those named: downwards only.
BELOW = {
    "tether": {"environment"},
    "vessel": {"environment"},
    "estimator": {"tether"},
    "observer": {"vessel"},
    "controller": {"tether", "vessel"},
    "vision": {"tether"},
}
TOP_LEVEL = {"pyproject.toml", "components", "scenarios", "pipeline", "tests", "logs", "docs"}
TOP_LEVEL |= {"README.md", "Makefile", "LICENSE", "CHANGELOG.md", ".ci", ".gitignore", ".pre-commit-config.yaml"}


def imports(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_file_says_what_it_is_and_stays_short(path):
    text = path.read_text()
    assert ast.get_docstring(ast.parse(text)) or not text.strip(), "no docstring"
    assert text.count("\n") <= 400, "a file has one subject and rarely passes 400 lines"


@pytest.mark.parametrize("path", COMPONENT_FILES, ids=label)
def test_component_knows_only_what_is_below_it(path):
    family, folder, name = path.relative_to(ROOT / "components").parts
    for module in imports(path):
        root, *rest = module.split(".")
        if root == "components" and len(rest) >= 2 and (ROOT / "components" / rest[0]).is_dir():
            shared = (ROOT / "components" / rest[0] / f"{rest[1]}.py").is_file()
            below = BELOW.get(family, set())
            own = (rest[0] == family and rest[1] == folder) or (rest[0] in {family, *below} and shared)
            if name in BORDER:
                assert own, f"{name} imports another component's {module}"
            else:
                assert rest[0] == family or rest[0] in below, f"{module} is not below {family}"
                assert own or rest[-1] not in ("model", "component"), f"physics imports the border {module}"
        elif name not in BORDER:
            assert root in PHYSICS_MAY_IMPORT | ALSO.get(family, set()), f"physics imports {module}"


def test_top_level_is_what_the_readme_says():
    tracked = {p.name for p in ROOT.iterdir() if p.name not in {".git", ".venv"} and not p.name.endswith("_cache")}
    assert {name for name in tracked if not name.startswith(".hypothesis")} <= TOP_LEVEL
