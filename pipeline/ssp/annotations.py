"""What an SSP has no words for, kept as annotations of Towline's that other tools pass over."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element as Xml
from xml.etree.ElementTree import SubElement

from pipeline import archive
from pipeline.ssp.ssv import SSC, SSD
from pipeline.xml_source import parse_xml

TYPE = "towline"
LARGEST = 64_000_000  # bytes of a document in an FMU


def read(element: Any) -> dict[str, Any]:
    """Towline's annotation of an element; of others, or of wrong contents, nothing."""
    for one in element.iterchildren():
        if str(one.tag).endswith("}Annotations"):
            for annotation in one.iterchildren(f"{SSC}Annotation"):
                if annotation.get("type") == TYPE:
                    return _object(annotation.findtext("{*}Settings") or "")
    return {}


def write(element: Xml, settings: dict[str, Any]) -> None:
    """Annotate an element of an SSD."""
    holder = SubElement(element, f"{SSD}Annotations")
    one = SubElement(holder, f"{SSC}Annotation", type=TYPE)
    SubElement(one, "Settings").text = json.dumps(settings)


def _object(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def member(fmu: Path, source: str) -> Any:
    """The root of a document in an FMU."""
    return parse_xml(archive.read(fmu, "FMU", source, LARGEST), f"{fmu}: {source}")
