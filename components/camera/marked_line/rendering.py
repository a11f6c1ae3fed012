"""One image: what stands still is painted once and kept, the line, its markers and particles are drawn over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from components.camera.marked_line import drawing, exposure, tank
from components.camera.optics import Optics


class Setting(NamedTuple):
    """All that an image depends on beside the line's nodes, the time and the frame's number.

    size: width and height [pixel]; sigma: blur of the lens [pixel]; marks: (j, 3) discs fixed in the tank, NED [m];
    mark_radius [m], mark_level [grey level]; obstacles: (k, 5) as paint_obstacle takes them; obstacle_level;
    seed: its two halves.
    """

    size: tuple[int, int]
    optics: Optics
    tank: tank.Tank
    line: drawing.Line
    particles: exposure.Particles
    sigma: float
    marks: np.ndarray
    mark_radius: float
    mark_level: float
    obstacles: np.ndarray
    obstacle_level: float
    seed: tuple[float, float]


class Still(NamedTuple):
    """What does not move: scene sharp and blurred, light in the motion plane, what obstacles hide; (h, w) float32."""

    sharp: np.ndarray
    blurred: np.ndarray
    light: np.ndarray
    hidden: np.ndarray


class Seen(NamedTuple):
    """An image (h, w) uint8; of its markers the true position (m, 3) NED [m], pixel (m, 2), share visible (m,)."""

    image: np.ndarray
    position: np.ndarray
    pixel: np.ndarray
    visible: np.ndarray


QUANTILES = exposure.normal_quantiles()


def paint(setting: Setting) -> Still:
    """The tank with its marks and obstacles."""
    width, height = setting.size
    sharp, light, hidden = (np.zeros((height, width), np.float32) for _ in range(3))
    tank.paint_tank(setting.optics, setting.tank, *setting.seed, sharp, light)
    for n, e, d in setting.marks:
        tank.paint_disc(setting.optics, light, sharp, n, e, d, setting.mark_radius, setting.mark_level)
    for obstacle in setting.obstacles:
        tank.paint_obstacle(setting.optics, obstacle, np.empty((4, 2)), hidden)
    blurred = sharp + hidden * (np.float32(setting.obstacle_level) * light - sharp)
    exposure.blur(blurred, exposure.gaussian_taps(setting.sigma), np.empty_like(blurred))
    return Still(sharp, blurred, light, hidden)


def render(
    setting: Setting,
    still: Still,
    sensor: exposure.Sensor,
    particle_level: float,
    nodes: np.ndarray,
    t: float,
    frame: int,
) -> Seen:
    """The image of a line through nodes (n+1, 3) NED at t [s]; frame: its number from 0."""
    width, height = setting.size
    optics, line = setting.optics, setting.line
    position, pixel, visible = np.empty((line.markers, 3)), np.empty((line.markers, 2)), np.empty(line.markers)
    drawn = np.empty(((len(nodes) - 1) * drawing.CHORDS + 1, drawing.VALUES))
    drawing.place_markers(line, nodes, position)
    drawing.trace(optics, line, nodes, drawn, np.empty(3))
    taps = exposure.gaussian_taps(setting.sigma)
    across = max(line.marker_radius / line.radius, 1.0) * max(drawn[:, drawing.HALF].max(), 0.0)
    top, bottom, left, right = drawing.window_of(drawn, across + len(taps) // 2 + 2.0, (height, width))
    light = still.blurred.copy()
    inside = (slice(top, max(bottom, top)), slice(left, max(right, left)))
    cover, side, delta = (np.zeros_like(light[inside]) for _ in range(3))
    near = optics._replace(cu=optics.cu - left, cv=optics.cv - top)
    drawn[:, : drawing.HALF] -= (left, top)
    views = [layer[inside] for layer in (still.sharp, still.light, still.hidden)]
    sharp, lit, hidden = (np.ascontiguousarray(view) for view in views)
    drawing.draw_line(line, drawn, sharp, lit, cover, side, delta)
    for i in range(line.markers):
        u, v, visible[i] = drawing.draw_marker(near, line, position[i], sharp, lit, hidden, delta)
        pixel[i] = u + left, v + top
    drawing.hide(hidden, delta)
    if delta.size:
        exposure.blur(delta, taps, cover)
        light[inside] += delta
    particles = setting.particles._replace(level=particle_level)
    exposure.draw_particles(optics, particles, *setting.seed, t, setting.sigma, np.empty(3), light)
    grey = np.empty((height, width), np.uint8)
    exposure.expose(sensor, QUANTILES, *setting.seed, frame, light, grey)
    return Seen(grey, position, pixel, visible)
