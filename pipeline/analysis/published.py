"""Published statistics to compare a scenario's with: scenarios/published/*.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import yaml

import components
from pipeline.analysis.statistics import Summary
from pipeline.errors import TowlineError

FOLDER = Path(components.__file__).parent.parent / "scenarios" / "published"


@dataclass(frozen=True)
class Published:
    """A table of a paper: the indicators' statistics, alpha in degrees, distances in mm."""

    source: str
    table: str
    alpha_deg: Summary
    e_plane_mm: Summary
    e_catenary_mm: Summary


def published(scenario: str, folder: Path = FOLDER) -> Published | None:
    """What is published of the experiment that this scenario repeats, or None.

    Raises TowlineError if a file there cannot be understood.
    """
    for path in sorted(folder.glob("*.yaml")):
        try:
            document = yaml.safe_load(path.read_text())
            if table := document["scenarios"].get(scenario):
                summaries = [Summary(**table[key]) for key in ("alpha_deg", "e_plane_mm", "e_catenary_mm")]
                return Published(document["source"], table["table"], *summaries)
        except (OSError, yaml.YAMLError, KeyError, TypeError, AttributeError) as error:
            raise TowlineError(f"{path}: not a file of published statistics: {error}") from error
    return None
