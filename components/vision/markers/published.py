"""Method `published`: the morphological steps of Trigo et al. 2014, section 2.2, to centroids of objects.

Names I1 to I17 are the paper's. Where its text is void or contradicts itself:
- (d) says a circle of radius 4 for the opening, text and figure 6 a radius of 1; 4 would remove the riser: 1 is taken.
- (e) is carried on until nothing changes (reconstruction), as its purpose, a mask of the whole riser, asks for.
- The gradient's scale is not given: Sobel's is divided by 4, so that a step has its own height, with 60 as threshold.
- (f) and (h) as printed leave I17 = I12, since a dilation within I12 adds nothing to it and bifurcations drop out; I16
  is not used. Objects around both are meant: I17 = max(I13, I14) is taken, all within 5 pixels of either.
- A marker's closed outline has neither ends nor bifurcations; its whole skeleton is taken for them then.
"""

from __future__ import annotations

import cv2
import numpy as np

cv2.setNumThreads(1)  # one image takes one core, and the same bits

GRADIENT_THRESHOLD = 60
DISC_5 = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (11, 11))
CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))  # a circle of radius 1
LOG_TABLE = np.round(255.0 * np.log1p(np.arange(256)) / np.log(256.0)).astype(np.uint8)
# Golay's L, upright and aslant: 1 object, -1 background, 0 either, around a pixel clockwise from the upper left.
_RING = [(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0)]
_UPRIGHT, _ASLANT = [-1, -1, -1, 0, 1, 1, 1, 0], [0, -1, -1, -1, 0, 1, 0, 1]
MOST_PASSES = 64


def _turned(ring: list[int], by: int) -> np.ndarray:
    element = np.zeros((3, 3), np.int32)
    element[1, 1] = 1
    for k, place in enumerate(_RING):
        element[place] = ring[(k - by) % 8]
    return element


GOLAY_L = [_turned(ring, by) for by in (0, 2, 4, 6) for ring in (_UPRIGHT, _ASLANT)]


def without_background(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """I6 of steps (a) to (f): what of an image (H, W) uint8 is brighter than the reference, where it is a riser."""
    i1 = cv2.subtract(image, reference)
    i2 = cv2.LUT(i1, LOG_TABLE)
    _, i3 = cv2.threshold(i2, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    i4 = cv2.morphologyEx(i3, cv2.MORPH_OPEN, CROSS)
    i5 = reconstructed(i4, i3)
    return cv2.min(i1, i5)


def reconstructed(seeds: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The objects of a binary mask (0, 255) that hold a seed: the geodesic dilation without end (Vincent 1993)."""
    count, labelled = cv2.connectedComponents(mask, connectivity=8)
    labels = np.asarray(labelled, np.int32)
    keep = np.zeros(count, np.uint8)
    keep[labels[seeds > 0]] = 255
    keep[0] = 0
    return np.take(keep, labels)


def targets(i6: np.ndarray) -> np.ndarray:
    """I9: the image's strong gradients, opened."""
    gu, gv = cv2.Sobel(i6, cv2.CV_32F, 1, 0), cv2.Sobel(i6, cv2.CV_32F, 0, 1)
    i8 = (0.25 * cv2.magnitude(gu, gv) > GRADIENT_THRESHOLD).astype(np.uint8) * np.uint8(255)
    return cv2.morphologyEx(i8, cv2.MORPH_OPEN, CROSS)


def skeleton(binary: np.ndarray) -> np.ndarray:
    """I10: thinning by Golay's L until nothing changes (Serra 1982)."""
    thin = binary.copy()
    for _ in range(MOST_PASSES):
        before = thin.copy()
        for element in GOLAY_L:
            thin[cv2.morphologyEx(thin, cv2.MORPH_HITMISS, element) > 0] = 0
        if np.array_equal(before, thin):
            break
    return thin


def ends_and_forks(thin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """I12 and I11: pixels of a skeleton with one neighbour, and with three or more in separate directions."""
    on = (thin > 0).astype(np.uint8)
    wide = np.pad(on, 1)
    height, width = on.shape
    ring = [wide[i : i + height, j : j + width] for i, j in _RING]
    neighbours = sum(ring)
    # Crossing number: how often the ring goes from background to object.
    crossings = sum((1 - ring[k]) & ring[(k + 1) % 8] for k in range(8))
    ends = np.where((on > 0) & (neighbours == 1), 255, 0).astype(np.uint8)
    forks = np.where((on > 0) & (crossings >= 3), 255, 0).astype(np.uint8)
    return ends, forks


def points_of(i9: np.ndarray) -> np.ndarray:
    """I11 and I12 together, of each object's skeleton by itself."""
    points = np.zeros_like(i9)
    count, labels, boxes, _ = cv2.connectedComponentsWithStats(i9, connectivity=8)
    for k in range(1, count):
        left, top, width, height = boxes[k, :4]
        place = (slice(max(top - 1, 0), top + height + 1), slice(max(left - 1, 0), left + width + 1))
        thin = skeleton(np.where(labels[place] == k, 255, 0).astype(np.uint8))
        ends, forks = ends_and_forks(thin)
        found = cv2.max(ends, forks)
        points[place] = cv2.max(points[place], found if found.any() else thin)
    return points


def centroids(i6: np.ndarray) -> np.ndarray:
    """(k, 2) pixels of the objects' centroids, from left to right."""
    i9 = targets(i6)
    rows, columns = np.flatnonzero(i9.any(axis=1)), np.flatnonzero(i9.any(axis=0))
    if not len(rows):
        return np.empty((0, 2))
    # Only where there is anything, with room for the dilation.
    top, left = max(rows[0] - 8, 0), max(columns[0] - 8, 0)
    part = np.ascontiguousarray(i9[top : rows[-1] + 9, left : columns[-1] + 9])
    i17 = cv2.dilate(points_of(part), DISC_5)
    count, _, _, middles = cv2.connectedComponentsWithStats(i17, connectivity=8)
    found = middles[1:count] + np.array([left, top])
    return found[np.argsort(found[:, 0])]
