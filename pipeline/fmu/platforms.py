"""Names of this machine's platform in FMUs."""

from __future__ import annotations

import platform

from pipeline.errors import TowlineError

MACHINES = {"x86_64": "x86_64", "amd64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def folder_here(fmi: int) -> str:
    """The folder of binaries for this machine in an FMU of a version of the standard. Raises TowlineError."""
    machine = MACHINES.get(platform.machine().lower())
    if platform.system() != "Linux" or machine is None:
        here = f"{platform.system()} {platform.machine()}"
        raise TowlineError(f"FMUs are built and run on Linux, x86-64 or ARM 64; this is {here}")
    return "linux64" if fmi < 3 and machine == "x86_64" else f"{machine}-linux"
