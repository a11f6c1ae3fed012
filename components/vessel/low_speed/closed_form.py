"""Transfer functions and drift coefficients of a box-shaped hull in closed form, by frequency and direction."""

import numpy as np

from components.vessel.low_speed.seakeeping import CELL

# Grid of the table [rad/s]: swell of 42 s to wind waves of 2.5 s, denser than a roll resonance of 5 % damping is wide.
FREQUENCIES = np.linspace(0.15, 2.5, 48)
DIRECTIONS = 13


def first_order_bessel(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Modified Bessel functions I_1 and K_1 of x > 0, by their integrals (Abramowitz and Stegun, 9.6.19 and 9.6.24)."""
    angle = (np.arange(64) + 0.5) * np.pi / 64
    t = np.linspace(0.0, 12.0, 2401)
    weights = np.full(len(t), t[1])
    weights[[0, -1]] *= 0.5
    i1 = np.mean(np.exp(np.outer(x, np.cos(angle))) * np.cos(angle), axis=1)
    k1 = np.exp(-np.outer(x, np.cosh(t))) @ (np.cosh(t) * weights)
    return i1, k1


def reflected(k: np.ndarray, draught: float) -> np.ndarray:
    """Square of the part of a wave's amplitude that a wall of a draught [m] reflects; Ursell 1947, in deep water."""
    i1, k1 = first_order_bessel(k * draught)
    return (np.pi * i1) ** 2 / ((np.pi * i1) ** 2 + k1**2)


def _mean(sigma: np.ndarray) -> np.ndarray:
    """sin(sigma) / sigma, of a wave along a length."""
    return np.sinc(sigma / np.pi)


def _turn(sigma: np.ndarray, length: float) -> np.ndarray:
    """6 / (L sigma) (sin(sigma) / sigma - cos(sigma)): the slope that fits a wave of unit amplitude best; odd."""
    near = np.where(abs(sigma) < 1e-3, 1.0, sigma)
    return np.where(abs(sigma) < 1e-3, 2.0 * sigma / length, 6.0 / (length * near) * (_mean(near) - np.cos(near)))


def heave_and_pitch(k, cosine, length, beam, draught):
    """Complex heave (down) [m/m] and pitch (bow up) [rad/m]; Jensen, Mansour, Olsen 2004 (Ocean Eng. 31), eqs. 3 to 10.

    At zero speed, alpha = 1. k: wave numbers [1/m]; cosine: of the wave's direction to the bow's.
    """
    sigma = 0.5 * k * length * cosine
    a = 2.0 * np.sin(0.5 * k * beam) * np.exp(-k * draught)
    damping = a * a / (k * beam)
    force = np.exp(-k * abs(cosine) * draught) * np.hypot(1.0 - k * draught, damping)
    operator = 1.0 - 2.0 * k * draught - 1j * damping
    return -force * _mean(sigma) / operator, 1j * force * _turn(sigma, length) / operator


def table(
    length: float, beam: float, draught: float, roll_frequency: float, roll_damping: float, bow: float, lever: float,
    density: float, gravity: float,
) -> np.ndarray:  # fmt: skip
    """The table of seakeeping.look_up for a hull in deep water; lengths [m], roll_frequency [rad/s], density [kg/m^3].

    Heave and pitch: heave_and_pitch(). Surge, sway and yaw: the water's own, averaged over the hull at half the
    draught, as a body does that is short against the wave. Roll: one degree of freedom under the averaged slope. Drift:
    the short-wave limit of a straight side and of ends of which `bow` reflects (Faltinsen 1990, eq. 5.24), times the
    part of the wave that a wall of the draught reflects; lever [m]: of the sway drift ahead of the reference point.
    """
    chi = np.linspace(0.0, np.pi, DIRECTIONS)[:, None]
    omega = FREQUENCIES[None, :]
    c, s = np.cos(chi), np.sin(chi)
    k = omega * omega / gravity
    sigma, across = 0.5 * k * length * c, _mean(0.5 * k * beam * s)
    depth = np.exp(-0.5 * k * draught)
    heave, pitch = heave_and_pitch(k, c, length, beam, draught)
    ratio = omega / roll_frequency
    roll = -1j * k * s * _mean(sigma) * across * depth / (1.0 - ratio**2 - 2j * roll_damping * ratio)
    surge, sway = 1j * c * _mean(sigma) * depth, 1j * s * _mean(sigma) * across * depth
    yaw = -s * _turn(sigma, length) * depth
    push = 0.5 * density * gravity * reflected(k[0], draught)[None, :]
    drift = push * beam * bow * c * abs(c), push * length * s * abs(s)
    cells = np.empty((DIRECTIONS, len(FREQUENCIES), CELL))
    for j, mode in enumerate((surge, sway, heave, roll, pitch, yaw)):
        cells[:, :, 2 * j], cells[:, :, 2 * j + 1] = np.real(mode), np.imag(mode)
    cells[:, :, 12], cells[:, :, 13], cells[:, :, 14] = *drift, lever * drift[1]
    return np.concatenate([[len(FREQUENCIES), DIRECTIONS], FREQUENCIES, cells.ravel()])
