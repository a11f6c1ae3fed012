"""The tank as the camera sees it without the line: wall, floor with joints between its slabs, marks, falloff of light.

All levels are grey levels (0 to 255) where the light is 1: in the middle of the view, in the motion plane.
"""

from math import exp, floor, sqrt
from typing import NamedTuple

import numpy as np

from components.camera.optics import plane_derivatives, project, ray
from components.compiled import kernel
from components.random import uniform

OCTAVES, COARSEST = 4, 0.8  # of the texture: wavelengths 0.8, 0.4, 0.2, 0.1 m
ROWS = 16  # sub-rows of a pixel in a disc's coverage


class Tank(NamedTuple):
    """plane: east of the motion plane; wall: east of the wall behind it; floor: depth of the floor [m].

    slab: distance of joints on floor and wall, joint: their width [m]; levels of wall, floor and joints [grey level];
    texture: standard deviation of the surfaces' brightness, relative; lamp: (3,) NED [m];
    attenuation: of light along its way to the scene and back [1/m].
    """

    plane: float
    wall: float
    floor: float
    slab: float
    joint: float
    wall_level: float
    floor_level: float
    joint_level: float
    texture: float
    lamp: np.ndarray
    attenuation: float


@kernel
def irradiance(tank, optics, north, east, down):
    """Light from the lamp that comes back from a point to the camera: inverse square and attenuation, unscaled."""
    n, e, d = north - tank.lamp[0], east - tank.lamp[1], down - tank.lamp[2]
    there = n * n + e * e + d * d
    n, e, d = north - optics.north, east - optics.east, down - optics.down
    way = sqrt(there) + sqrt(n * n + e * e + d * d)
    return exp(-tank.attenuation * way) / there


@kernel
def surface_noise(high, low, stream, a, b):
    """Smooth noise of unit variance on a surface (a, b) [m]: octaves of random values on lattices."""
    total, wave = 0.0, COARSEST
    for octave in range(OCTAVES):
        i, j = floor(a / wave), floor(b / wave)
        f, g = a / wave - i, b / wave - j
        f, g = f * f * (3.0 - 2.0 * f), g * g * (3.0 - 2.0 * g)
        value = 0.0
        for k in range(4):
            di, dj = k & 1, k >> 1
            at = (int(i) + di + 1048576) * 2097152 + int(j) + dj + 1048576
            r, _ = uniform(high, low, stream + octave, at)
            value += (r - 0.5) * (f if di else 1.0 - f) * (g if dj else 1.0 - g)
        total += value
        wave *= 0.5
    # A lattice value has variance 1/12; the cubic between four of them leaves (26/35)^2 of it on the average.
    return total * sqrt(12.0 / OCTAVES) * 35.0 / 26.0


@kernel
def joint_cover(a, spacing, width, footprint):
    """Share of a pixel of this footprint at a that lies on joints of this width, one each spacing."""
    a -= spacing * floor(a / spacing + 0.5)
    low, high = max(a - 0.5 * footprint, -0.5 * width), min(a + 0.5 * footprint, 0.5 * width)
    return max(high - low, 0.0) / footprint


@kernel
def paint_tank(optics, tank, high, low, scene, light):
    """Fill scene with the tank's levels and light with the light in the motion plane, (height, width) float32 each.

    high, low: the seed's halves; streams 100 and on are the texture's.
    """
    height, width = scene.shape
    n, e, d = ray(optics, 0.5 * (width - 1), 0.5 * (height - 1))
    s = (tank.plane - optics.east) / e
    unit = irradiance(tank, optics, optics.north + s * n, tank.plane, optics.down + s * d)
    for v in range(height):
        for u in range(width):
            n, e, d = ray(optics, float(u), float(v))
            fall = 1.0 / (n * n + e * e + d * d) ** 2  # cos^4 of the angle from the optical axis
            s = (tank.plane - optics.east) / e
            light[v, u] = fall * irradiance(tank, optics, optics.north + s * n, tank.plane, optics.down + s * d) / unit
            s = (tank.wall - optics.east) / e
            level, stream = tank.wall_level, 100
            if optics.down + s * d > tank.floor:
                s, level, stream = (tank.floor - optics.down) / d, tank.floor_level, 200
            north, east, down = optics.north + s * n, optics.east + s * e, optics.down + s * d
            a, b = north, down if stream == 100 else east
            if tank.joint > 0.0:
                foot = s / optics.f
                slant = foot * sqrt(n * n + e * e + d * d) / abs(d) if stream == 200 else foot
                cover = joint_cover(a, tank.slab, tank.joint, foot)
                cover += (1.0 - cover) * joint_cover(b, tank.slab, tank.joint, slant)
                level += cover * (tank.joint_level - level)
            if tank.texture > 0.0:
                level *= max(1.0 + tank.texture * surface_noise(high, low, stream, a, b), 0.0)
            scene[v, u] = level * fall * irradiance(tank, optics, north, east, down) / unit


@kernel
def disc_row(a, b, c, u0, v0, u, v):
    """Share of the pixel (u, v) inside the ellipse a x^2 + 2 b x y + c y^2 <= 1 about (u0, v0).

    Exact along u, by ROWS middles along v.
    """
    cover = 0.0
    for k in range(ROWS):
        y = v - v0 + (k + 0.5) / ROWS - 0.5
        root = b * b * y * y - a * (c * y * y - 1.0)
        if root > 0.0:
            root = sqrt(root)
            left, right = (-b * y - root) / a, (-b * y + root) / a
            cover += max(min(right, u - u0 + 0.5) - max(left, u - u0 - 0.5), 0.0)
    return cover / ROWS


@kernel
def ellipse_of(optics, north, east, down, radius):
    """The image of a disc in a plane of constant east: a, b, c, centre, half extents, depth (at most 0: unseen)."""
    u0, v0, z = project(optics, north, east, down)
    if z <= 0.0:
        return 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, z
    un, ud, vn, vd = plane_derivatives(optics, north, east, down)
    # |J^-1 (x, y)| <= radius.
    scale = (radius * (un * vd - ud * vn)) ** 2
    a, b, c = (vn * vn + vd * vd) / scale, -(un * vn + ud * vd) / scale, (un * un + ud * ud) / scale
    return a, b, c, u0, v0, radius * sqrt(un * un + ud * ud), radius * sqrt(vn * vn + vd * vd), z


@kernel
def paint_disc(optics, light, scene, north, east, down, radius, level):
    """Paint a disc that faces along east onto the scene."""
    height, width = scene.shape
    a, b, c, u0, v0, du, dv, z = ellipse_of(optics, north, east, down, radius)
    if z <= 0.0 or not (-du < u0 < width + du and -dv < v0 < height + dv):
        return
    for v in range(max(int(v0 - dv) - 1, 0), min(int(v0 + dv) + 3, height)):
        for u in range(max(int(u0 - du) - 1, 0), min(int(u0 + du) + 3, width)):
            cover = disc_row(a, b, c, u0, v0, float(u), float(v))
            scene[v, u] += cover * (level * light[v, u] - scene[v, u])


@kernel
def edge_cover(optics, corners, k, u, v):
    """How far the pixel lies inside edge k of a quadrilateral with corners (4, 2), clockwise in the image [pixel]."""
    au, av = corners[k, 0], corners[k, 1]
    bu, bv = corners[(k + 1) % 4, 0] - au, corners[(k + 1) % 4, 1] - av
    return ((v - av) * bu - (u - au) * bv) / sqrt(bu * bu + bv * bv)


@kernel
def paint_obstacle(optics, obstacle, corners, cover):
    """Add to cover (height, width) the share of each pixel behind a rectangle in a plane of constant east.

    obstacle: (5,) north from and to, down from and to, east [m]; corners: (4, 2) scratch.
    """
    height, width = cover.shape
    for k in range(4):
        north = obstacle[0] if k in (0, 3) else obstacle[1]
        down = obstacle[2] if k < 2 else obstacle[3]
        corners[k, 0], corners[k, 1], z = project(optics, north, obstacle[4], down)
        if z <= 0.0:
            return
    area = 0.0
    for k in range(4):
        j = (k + 1) % 4
        area += corners[k, 0] * corners[j, 1] - corners[j, 0] * corners[k, 1]
    turn = 1.0 if area > 0.0 else -1.0
    for v in range(height):
        for u in range(width):
            inside = 1.0
            for k in range(4):
                inside = min(inside, max(turn * edge_cover(optics, corners, k, float(u), float(v)) + 0.5, 0.0))
            cover[v, u] = max(cover[v, u], inside)
