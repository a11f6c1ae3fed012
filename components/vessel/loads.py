"""Ports of loads on a vessel in the horizontal plane."""

from __future__ import annotations

from components.contract import Port


def load_ports(bundle: str) -> tuple[Port, ...]:
    """A force and a moment on the vessel about its reference point."""
    return (
        Port(f"{bundle}.force", "N", (2,), "body", "surge and sway"),
        Port(f"{bundle}.moment", "N*m", (), "body", "yaw"),
    )
