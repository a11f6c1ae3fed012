"""XML of anyone's, parsed without entities, document types, networks or trees of absurd depth."""

from __future__ import annotations

from typing import Any

from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from pipeline.errors import TowlineError


def parse_xml(data: bytes, shown: str) -> Any:
    """The root element. Raises TowlineError with `shown`, the document's name, and the line."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        root = etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise TowlineError(f"{shown} cannot be read: {(str(error).splitlines() or ['empty'])[0]}") from error
    if root is None:
        raise TowlineError(f"{shown} cannot be read: it is empty")
    if root.getroottree().docinfo.internalDTD is not None:
        raise TowlineError(f"{shown} declares a document type, by which entities expand or read files; it is refused")
    return root
