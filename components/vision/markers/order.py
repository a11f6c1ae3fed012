"""Method `published`: which centroid is which marker, by their order alone, and the reference image in the state."""

from __future__ import annotations

import numpy as np

from components.vision.markers import published, scales
from components.vision.markers.finding import Found, nothing

PACK = 256 ** np.arange(6)  # six bytes are a whole number below 2^48, which a float64 holds


def keep_reference(image: np.ndarray, x: np.ndarray) -> None:
    """Keep an image (H, W) uint8 in x, six pixels a number."""
    pixels = np.zeros(len(PACK) * len(x), np.int64)
    pixels[: image.size] = image.ravel()
    x[:] = pixels.reshape(-1, len(PACK)) @ PACK


def reference_of(x: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The image kept in x."""
    octets = x.astype("<i8").view(np.uint8).reshape(-1, 8)[:, : len(PACK)]
    return np.ascontiguousarray(octets).ravel()[: shape[0] * shape[1]].reshape(shape)


def find(
    affinity: scales.Affinity,
    deviation: float,
    first: np.ndarray,
    markers: int,
    image: np.ndarray,
    reference: np.ndarray,
) -> Found:
    """The markers of an image: the last centroid from the left is the last marker, and so on down.

    The paper's markers are told apart by their order; those lying still vanish with the background. Where one is missed
    or a false object found, those before it have a wrong number. Covariances are the stated deviation's [pixel].
    """
    middles = published.centroids(published.without_background(image, reference))[-markers:]
    result, k = nothing(markers), markers - len(middles)
    own, metric = deviation**2 * np.eye(2), turned_scales(affinity)
    result.pixel[k:], result.plane[k:] = middles, scales.to_plane(affinity, middles, first)
    result.pixel_covariance[k:], result.covariance[k:] = own, metric @ own @ metric.T
    result.valid[k:] = True
    return result


def turned_scales(affinity: scales.Affinity) -> np.ndarray:
    """(2, 2) derivatives of north and down by column and row [m/pixel]."""
    return np.diag([affinity.s_x, affinity.s_y]) @ scales.aligned(np.eye(2), affinity.angle).T
