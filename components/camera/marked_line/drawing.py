"""The line and its markers drawn over the tank: shares of pixels covered, exact enough to find a marker to 0.01 pixel.

What is drawn is the difference that the line makes to each pixel before blur, in a window around it.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from components.camera.marked_line.tank import disc_row, ellipse_of
from components.camera.optics import project
from components.compiled import kernel
from components.placement import cell, weights

CHORDS = 6  # a segment of the line is drawn as
SHADE = 0.15  # of the line's level: brighter on its upper side by this share, darker on the lower
U, V, HALF, VALUES = 0, 1, 2, 3  # of a drawn point: pixel, half the line's width there


class Line(NamedTuple):
    """length: unstretched, of the wired segments [m]; radius: of the line, marker_radius: of the discs on it [m].

    first: distance of the first marker from end a, spacing: of the markers [m]; markers: their number;
    level, marker_level: in unit light [grey level].
    """

    length: float
    radius: float
    marker_radius: float
    first: float
    spacing: float
    markers: int
    level: float
    marker_level: float


@kernel
def point_at(nodes, xi, out):
    """Position (3,) at xi in segments from end a on the line through nodes (n+1, 3)."""
    first, f = cell(xi, len(nodes) - 1)
    a, b, c, d = weights(f)
    for k in range(3):
        out[k] = a * nodes[first, k] + b * nodes[first + 1, k] + c * nodes[first + 2, k] + d * nodes[first + 3, k]


@kernel
def place_markers(line, nodes, positions):
    """Fill positions (m, 3) of the markers, NED."""
    segments = len(nodes) - 1
    for i in range(line.markers):
        point_at(nodes, (line.first + i * line.spacing) / line.length * segments, positions[i])


@kernel
def trace(optics, line, nodes, drawn, point):
    """Fill drawn (segments CHORDS + 1, VALUES) along the line; half widths are negative behind the camera."""
    for k in range(len(drawn)):
        point_at(nodes, k / CHORDS, point)
        u, v, z = project(optics, point[0], point[1], point[2])
        drawn[k, U], drawn[k, V], drawn[k, HALF] = u, v, optics.f * line.radius / z if z > 0.0 else -1.0


@kernel
def draw_chord(drawn, k, cover, side):
    """Raise cover, by the chord from drawn point k to the next, and note on which side of it a pixel lies (-1 to 1)."""
    height, width = cover.shape
    au, av, half = drawn[k, U], drawn[k, V], 0.5 * (drawn[k, HALF] + drawn[k + 1, HALF])
    bu, bv = drawn[k + 1, U] - au, drawn[k + 1, V] - av
    square = bu * bu + bv * bv
    if drawn[k, HALF] < 0.0 or drawn[k + 1, HALF] < 0.0 or square == 0.0:
        return
    pad, long = half + 1.0, sqrt(square)
    for v in range(max(int(min(av, av + bv) - pad), 0), min(int(max(av, av + bv) + pad) + 2, height)):
        for u in range(max(int(min(au, au + bu) - pad), 0), min(int(max(au, au + bu) + pad) + 2, width)):
            s = min(max(((u - au) * bu + (v - av) * bv) / square, 0.0), 1.0)
            du, dv = u - au - s * bu, v - av - s * bv
            inside = min(max(half + 0.5 - sqrt(du * du + dv * dv), 0.0), 1.0)
            if inside > cover[v, u]:
                cover[v, u] = inside
                across = ((v - av) * bu - (u - au) * bv) / long
                side[v, u] = min(max((-across if bu > 0.0 else across) / max(half, 0.5), -1.0), 1.0)


@kernel
def window_of(drawn, pad, shape):
    """Rows and columns (v0, v1, u0, u1) of the pixels within pad of the drawn points; empty ones where none is seen."""
    height, width = shape
    top, bottom, left, right = height, 0, width, 0
    for k in range(len(drawn)):
        if drawn[k, HALF] >= 0.0:
            # Bounded before it becomes a whole number: a point beside the camera is seen at any distance.
            u, v = min(max(drawn[k, U], -1e6), 1e6), min(max(drawn[k, V], -1e6), 1e6)
            if -pad < u < width + pad and -pad < v < height + pad:
                top, bottom = min(top, int(v - pad)), max(bottom, int(v + pad) + 2)
                left, right = min(left, int(u - pad)), max(right, int(u + pad) + 2)
    return max(top, 0), max(min(bottom, height), 0), max(left, 0), max(min(right, width), 0)


@kernel
def draw_line(line, drawn, scene, light, cover, side, delta):
    """Write into delta (height, width) what the line changes; cover and side are scratch of its shape."""
    for k in range(len(drawn) - 1):
        draw_chord(drawn, k, cover, side)
    height, width = delta.shape
    for v in range(height):
        for u in range(width):
            if cover[v, u] > 0.0:
                level = line.level * light[v, u] * (np.float32(1.0) + np.float32(SHADE) * side[v, u])
                delta[v, u] = cover[v, u] * (level - scene[v, u])


@kernel
def draw_marker(optics, line, position, scene, light, hidden, delta):
    """Paint a marker over what is drawn; its pixel (u, v) and the share of it that the camera sees.

    hidden: (height, width) share of each pixel behind an obstacle.
    """
    height, width = delta.shape
    a, b, c, u0, v0, du, dv, z = ellipse_of(optics, position[0], position[1], position[2], line.marker_radius)
    if z <= 0.0 or not (-du < u0 < width + du and -dv < v0 < height + dv):
        return u0, v0, 0.0
    total = seen = 0.0
    for v in range(int(v0 - dv) - 1, int(v0 + dv) + 3):
        for u in range(int(u0 - du) - 1, int(u0 + du) + 3):
            inside = disc_row(a, b, c, u0, v0, float(u), float(v))
            total += inside
            if inside > 0.0 and 0 <= v < height and 0 <= u < width:
                seen += inside * (1.0 - hidden[v, u])
                under = scene[v, u] + delta[v, u]
                delta[v, u] += inside * (line.marker_level * light[v, u] - under)
    return u0, v0, seen / total


@kernel
def hide(hidden, delta):
    """Take away what lies behind obstacles."""
    height, width = delta.shape
    for v in range(height):
        for u in range(width):
            delta[v, u] *= np.float32(1.0) - hidden[v, u]
