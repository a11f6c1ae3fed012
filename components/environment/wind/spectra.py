"""Wind over height and the spectra of its gusts: NPD (ISO 19901-1), Harris and Davenport."""

from __future__ import annotations

import numpy as np

KARMAN = 0.4
# Surface drag coefficient of a rough sea, and length scales [m], for Harris and Davenport.
SURFACE_DRAG, HARRIS_LENGTH, DAVENPORT_LENGTH = 0.0026, 1800.0, 1200.0


def mean_at(speed: float, height: float) -> float:
    """One-hour mean [m/s] at a height [m], from that at 10 m; ISO 19901-1:2005, eq. A.2 (NPD)."""
    return speed * (1.0 + 0.0573 * np.sqrt(1.0 + 0.15 * speed) * np.log(height / 10.0))


def intensity(speed: float, height: float) -> float:
    """Standard deviation of the gusts over the one-hour mean at that height; ISO 19901-1:2005, eq. A.4 (NPD)."""
    return 0.06 * (1.0 + 0.043 * speed) * (height / 10.0) ** -0.22


def npd(f: np.ndarray, speed: float, height: float) -> np.ndarray:
    """S(f) [m^2/s] of the gusts along the wind; ISO 19901-1:2005, eqs. A.6 and A.7. f [Hz]; speed at 10 m [m/s]."""
    n = 0.468
    reduced = 172.0 * f * (height / 10.0) ** (2.0 / 3.0) * (speed / 10.0) ** -0.75
    return 320.0 * (speed / 10.0) ** 2 * (height / 10.0) ** 0.45 / (1.0 + reduced**n) ** (5.0 / (3.0 * n))


def harris(f: np.ndarray, speed: float, height: float) -> np.ndarray:
    """S(f) [m^2/s], the same at all heights; Harris 1971, as DNV-RP-C205 (2010), section 2.3.5."""
    reduced = HARRIS_LENGTH * f / speed
    return 4.0 * SURFACE_DRAG * HARRIS_LENGTH * speed / (2.0 + reduced**2) ** (5.0 / 6.0)


def davenport(f: np.ndarray, speed: float, height: float) -> np.ndarray:
    """S(f) [m^2/s], the same at all heights; Davenport 1961, as DNV-RP-C205 (2010), section 2.3.5."""
    reduced = DAVENPORT_LENGTH * f / speed
    return 4.0 * SURFACE_DRAG * DAVENPORT_LENGTH * speed * reduced / (1.0 + reduced**2) ** (4.0 / 3.0)


SPECTRA = {"npd": npd, "harris": harris, "davenport": davenport}


def bins(lowest: float, highest: float, count: int) -> np.ndarray:
    """Edges (count + 1,) [Hz] of equal ratio."""
    return np.geomspace(lowest, highest, count + 1)


def amplitudes(spectrum: str, edges: np.ndarray, speed: float, height: float) -> np.ndarray:
    """Amplitude [m/s] of a harmonic for each bin, of the bin's variance: Simpson's rule in 8 parts over log f."""
    if speed == 0.0:
        return np.zeros(len(edges) - 1)
    parts = np.linspace(0.0, 1.0, 9)
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24.0
    logs = np.log(edges)[:, None]
    f = np.exp(logs[:-1] + np.diff(logs, axis=0) * parts)
    variance = (SPECTRA[spectrum](f, speed, height) * f) @ weights * np.diff(logs[:, 0])
    return np.sqrt(2.0 * variance)
