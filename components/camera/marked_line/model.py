"""A camera that sees a marked line in a tank: parameters, ports and sizes."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.camera.marked_line.drawing import Line
from components.camera.marked_line.exposure import Particles, Sensor
from components.camera.marked_line.rendering import Setting
from components.camera.marked_line.tank import Tank
from components.camera.optics import Optics, ray, turn_of
from components.contract import ImagePort, Parameters, Port, Sizes, Term, choice, quantity

Vector = tuple[float, float, float]
# North from and to, down from and to, east.
Rectangle = tuple[float, float, float, float, float]
SENSOR = 6  # numbers of the vector that belong to the sensor, the particles' level among them


class MarkedLine(Parameters):
    """A camera on one side of a tank, a line with round markers in a plane of constant east, a wall behind it.

    Levels are grey levels (0 to 255) at an exposure of 1, in the motion plane in the middle of the view.
    """

    width: Annotated[int, Field(ge=32)] = choice("columns of the image", 1280)
    height: Annotated[int, Field(ge=32)] = choice("rows of the image", 800)
    position: Vector = quantity("m", "of the camera, NED", tunable=True)
    heading: float = quantity("rad", "of its view from north", 1.5 * pi, tunable=True)
    pitch: float = quantity("rad", "of its view above the horizon", 0.0, tunable=True, gt=-1.5, lt=1.5)
    roll: float = quantity("rad", "clockwise, seen from behind the camera", 0.0, tunable=True)
    focal_length: float = quantity("m", "of the lens, in air", gt=0)
    refractive_index: float = quantity(
        "1", "of the water behind a flat port, by which the focal length grows", 1.33, ge=1
    )
    pixel_size: float = quantity("m", "distance of two pixels on the sensor", gt=0)
    distortion: float = quantity("1", "k of r_d = r (1 + k r^2), r in focal lengths", 0.0, gt=-0.3, lt=0.3)
    blur: float = quantity("pixel", "standard deviation of the lens's blur", 0.0, ge=0, le=20)

    length: float = quantity("m", "unstretched length of the line", gt=0)
    segments: Annotated[int, Field(ge=3)] = choice("number of equal segments of the line that is wired to nodes")
    diameter: float = quantity("m", "of the line", gt=0)
    markers: Annotated[int, Field(ge=1)] = choice("number of markers")
    first: float = quantity("m", "distance of the first marker from end a along the line", 0.0, ge=0)
    spacing: float = quantity("m", "distance of two markers along the unstretched line", gt=0)
    marker_diameter: float = quantity("m", "of the markers", gt=0)
    line_level: float = quantity("1", "of the line", 78.0, ge=0, le=255)
    marker_level: float = quantity("1", "of the markers", 205.0, ge=0, le=255)

    plane: float = quantity("m", "east of the plane in which the line moves", 0.0)
    wall: float = quantity("m", "east of the wall behind it")
    floor: float = quantity("m", "depth of the floor")
    wall_level: float = quantity("1", "of the wall", 34.0, ge=0, le=255)
    floor_level: float = quantity("1", "of the floor", 52.0, ge=0, le=255)
    slab: float = quantity("m", "distance of the joints on wall and floor", 0.5, gt=0)
    joint: float = quantity("m", "their width", 0.0, ge=0)
    joint_level: float = quantity("1", "of the joints", 22.0, ge=0, le=255)
    texture: float = quantity("1", "standard deviation of wall and floor, relative", 0.0, ge=0, le=1)
    marks: tuple[Vector, ...] = quantity("m", "round marks fixed in the tank, NED", ())
    mark_diameter: float = quantity("m", "of these", 0.036, gt=0)
    mark_level: float = quantity("1", "of these", 150.0, ge=0, le=255)
    obstacles: tuple[Rectangle, ...] = quantity("m", "what hides the line: north from, to, down from, to, east", ())
    obstacle_level: float = quantity("1", "of these", 14.0, ge=0, le=255)
    lamp: Vector = quantity("m", "position of the lamp, NED")
    attenuation: float = quantity("1/m", "of light in the water", 0.0, ge=0)

    particles: Annotated[int, Field(ge=0)] = choice("number of particles afloat in view", 0)
    particle_diameter: float = quantity("m", "of these", 0.004, gt=0)
    particle_level: float = quantity("1", "of these", 100.0, tunable=True, ge=0)
    particle_drift: Vector = quantity("m/s", "mean velocity of these, NED", (0.03, 0.0, 0.005))
    defocus: float = quantity("pixel", "blur of what is twice as near as the motion plane", 8.0, ge=0)

    exposure: float = quantity("1", "gain of all light", 1.0, tunable=True, ge=0)
    turbidity: float = quantity("1", "optical depth of haze before the scene", 0.0, tunable=True, ge=0)
    haze: float = quantity("1", "level of the haze", 40.0, tunable=True, ge=0)
    noise: float = quantity("1", "standard deviation of a pixel in the dark", 0.0, tunable=True, ge=0)
    shot: float = quantity("1", "variance that each grey level adds to a pixel", 0.0, tunable=True, ge=0)

    @model_validator(mode="after")
    def _scene_is_in_view(self) -> MarkedLine:
        ahead = self.plane - self.position[1]
        if ahead * (self.wall - self.plane) <= 0.0:
            raise ValueError(
                f"the camera is at {self.position[1]:g} m east, the line at {self.plane:g} m and the wall at "
                f"{self.wall:g} m: the line must be between them"
            )
        if self.floor <= self.position[2]:
            raise ValueError(f"the camera at a depth of {self.position[2]:g} m is below the floor at {self.floor:g} m")
        optics = self.optics()
        for u in (0.0, self.width - 1.0):
            for v in (0.0, self.height - 1.0):
                if ray(optics, u, v)[1] * ahead <= 0.0:
                    raise ValueError("not all of the image shows the motion plane: turn the camera, or narrow its view")
        return self

    @model_validator(mode="after")
    def _markers_are_on_the_line(self) -> MarkedLine:
        reach = self.first + (self.markers - 1) * self.spacing
        if reach > self.length * (1.0 + 1e-9):
            raise ValueError(
                f"the last of {self.markers} markers would be {reach:g} m from end a of a line of {self.length:g} m: "
                "expected fewer markers, a smaller spacing, or a smaller distance of the first"
            )
        return self

    def optics(self) -> Optics:
        """Its projection."""
        return Optics(
            *self.position,
            turn_of(self.heading, self.pitch, self.roll),
            self.refractive_index * self.focal_length / self.pixel_size,
            0.5 * (self.width - 1),
            0.5 * (self.height - 1),
            self.distortion,
        )

    def vector(self) -> np.ndarray:
        """The sensor's numbers, then those that the scene depends on; see setting_of."""
        optics = self.optics()
        sensor = [self.exposure, np.exp(-self.turbidity), self.haze, self.noise, self.shot, self.particle_level]
        box = view_box(self, optics)
        tank = [self.plane, self.wall, self.floor, self.slab, self.joint, self.wall_level, self.floor_level]
        tank += [self.joint_level, self.texture, *self.lamp, self.attenuation]
        line = [self.length, 0.5 * self.diameter, 0.5 * self.marker_diameter, self.first, self.spacing, self.markers]
        line += [self.line_level, self.marker_level]
        particles = [self.particles, *box, *self.particle_drift, self.particle_diameter, self.defocus]
        particles.append(abs(self.plane - self.position[1]))
        return np.concatenate(
            [
                [*sensor, self.width, self.height, self.segments],
                [optics.north, optics.east, optics.down, *optics.turn, optics.f, optics.cu, optics.cv, optics.k],
                [*tank, *line, *particles, self.blur, 0.5 * self.mark_diameter, self.mark_level, self.obstacle_level],
                [len(self.marks), len(self.obstacles), *np.ravel(self.marks), *np.ravel(self.obstacles)],
            ]
        )


def view_box(camera: MarkedLine, optics: Optics) -> list[float]:
    """North, east and down from and to, around what the camera sees between itself and the motion plane."""
    corners = []
    for u in (0.0, camera.width - 1.0):
        for v in (0.0, camera.height - 1.0):
            n, e, d = ray(optics, u, v)
            s = (camera.plane - optics.east) / e
            corners.append((optics.north + s * n, optics.down + s * d))
    north, down = np.array(corners).T
    near, far = optics.east + 0.2 * (camera.plane - optics.east), camera.plane
    return [north.min(), north.max(), min(near, far), max(near, far), down.min(), min(down.max(), camera.floor)]


def sensor_of(q: np.ndarray) -> tuple[Sensor, float]:
    """The sensor, and the level of the particles, from the parameters' vector."""
    exposure, clear, haze, noise, shot, particles = q[:SENSOR].tolist()
    return Sensor(exposure, clear, haze, noise, shot), particles


def setting_of(q: np.ndarray, seed: tuple[float, float]) -> Setting:
    """The scene from the parameters' vector; seed: its two halves."""
    rest = iter(q[SENSOR:].tolist())

    def take(count: int) -> list[float]:
        return [next(rest) for _ in range(count)]

    width, height, _ = (int(n) for n in take(3))
    optics = Optics._make([*take(3), np.array(take(9)), *take(4)])
    tank = Tank._make([*take(9), np.array(take(3)), *take(1)])
    length, radius, marker_radius, first, spacing, markers, *levels = take(8)
    line = Line._make([length, radius, marker_radius, first, spacing, int(markers), *levels])
    count, box, drift = int(next(rest)), np.array(take(6)), np.array(take(3))
    diameter, defocus, focus = take(3)
    particles = Particles(count, box, drift, diameter, 0.0, defocus, focus)
    blur, mark_radius, mark_level, obstacle_level = take(4)
    marks, obstacles = (int(n) for n in take(2))
    return Setting(
        (width, height),
        optics,
        tank,
        line,
        particles,
        blur,
        np.array(take(3 * marks)).reshape(-1, 3),
        mark_radius,
        mark_level,
        np.array(take(5 * obstacles)).reshape(-1, 5),
        obstacle_level,
        seed,
    )


def inputs(camera: MarkedLine) -> tuple[Port, ...]:
    """The line's nodes, equally spaced along the unstretched line."""
    return (Port("nodes", "m", (camera.segments + 1, 3), "NED", "node positions from end a to end b"),)


def outputs(camera: MarkedLine) -> tuple[Port, ...]:
    """The image at the end of the step, and beside it what is true of the markers."""
    m = camera.markers
    return (
        Port("marker_position", "m", (m, 3), "NED", "true positions of the markers, from end a on"),
        Port("marker_pixel", "pixel", (m, 2), "", "column and row of their centres; void where they are out of view"),
        Port("marker_visible", "1", (m,), "", "share of each that is in the image and not behind an obstacle"),
        ImagePort("image", shape=(camera.height, camera.width)),
    )


def sizes(_: MarkedLine) -> Sizes:
    """How many images were taken."""
    return Sizes(state=1)


def terms(camera: MarkedLine) -> tuple[Term, ...]:
    """What of the model is on."""
    return (
        Term("distortion", camera.distortion != 0.0, f"distortion {camera.distortion:g}"),
        Term("blur", camera.blur > 0.0, f"blur {camera.blur:g} pixel"),
        Term("noise", camera.noise + camera.shot > 0.0, f"noise {camera.noise:g}, shot {camera.shot:g}"),
        Term("particles", camera.particles > 0, f"{camera.particles} particles"),
        Term("obstacles", bool(camera.obstacles), f"{len(camera.obstacles)} obstacles"),
    )
