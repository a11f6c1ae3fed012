"""Markers read as the angles of the chords between them, whose noise is shared by neighbours."""

from math import cos, sin

from components.compiled import kernel

FAR = 1e9  # beyond which a number is no position [m], nor what another sensor says [N, rad, rad/s]
SMALLEST, NARROW = 1e-30, 1e-12  # variance of a marker [m^2], and what is left of it where the other way is known
# A chord that is shorter than this part of its bars, or by the noise longer, is none of this line.
SHORT = 0.7
MISSING, USED, REFUSED = 0.0, 1.0, -1.0


@kernel
def is_there(u, i, count):
    """Whether marker i of `count` has a position."""
    at = 3 * i
    return u[3 * count + i] > 0.0 and abs(u[at]) < FAR and abs(u[at + 2]) < FAR


@kernel
def spread(u, i, count, takes_covariance, variance, chain):
    """Covariance (north, both, down) of marker i about the chain [m^2]; where it is none, the parameters' variance.

    chain: variance of the markers from the chain, each way, in both cases.
    """
    if takes_covariance:
        at = 4 * count + 4 * i
        a, b, c = u[at], 0.5 * (u[at + 1] + u[at + 2]), u[at + 3]
        if min(a, c) > SMALLEST and max(a, c) < FAR * FAR and a * c * (1.0 - NARROW) > b * b:
            return a + chain, b, c + chain
    return variance + chain, 0.0, variance + chain


@kernel
def across(c, s, cov):
    """n' C n for the normal (-s, c) of a chord."""
    return s * s * cov[0] - 2.0 * s * c * cov[1] + c * c * cov[2]


@kernel
def between(angle, other, cov):
    """n' C m for the normals of two chords."""
    c, s, d, t = cos(angle), sin(angle), cos(other), sin(other)
    return s * t * cov[0] - (s * d + c * t) * cov[1] + c * d * cov[2]
