"""From light to grey levels: blur of the lens, haze, particles before it, exposure, noise of the sensor, eight bits."""

from math import erf, exp, floor, sqrt
from typing import NamedTuple

import numpy as np

from components.camera.optics import project
from components.compiled import kernel
from components.random import uniform, words

NOISE, BIRTH, DRIFT = 0, 1, 4  # streams of random numbers; BIRTH and DRIFT take three and two
SCATTER = 0.3  # of the particles' own speeds over the mean one
REACH = 4.0  # standard deviations of blur that are drawn
QUANTILES = 65536


def normal_quantiles() -> np.ndarray:
    """(65536,) float32 quantiles of the standard normal law at (k + 1/2) / 65536, by Newton's method on erf."""
    share = (np.arange(QUANTILES // 2, QUANTILES) + 0.5) / QUANTILES
    z = np.sqrt(np.maximum(-2.0 * np.log(2.0 * (1.0 - share)), 0.0)) * 0.9
    integral = np.vectorize(erf)
    for _ in range(30):
        density = np.exp(-0.5 * z * z) / sqrt(2.0 * np.pi)
        z -= np.clip((0.5 + 0.5 * integral(z / sqrt(2.0)) - share) / np.maximum(density, 1e-9), -0.5, 0.5)
    return np.concatenate([-z[::-1], z]).astype(np.float32)


def gaussian_taps(sigma: float) -> np.ndarray:
    """Weights (2 r + 1,) float32 of a blur by sigma [pixel], symmetric and of sum 1; a single 1 for sigma 0."""
    reach = int(np.ceil(REACH * sigma))
    at = np.arange(-reach, reach + 1)
    taps = np.exp(-0.5 * (at / sigma) ** 2) if sigma > 0.0 else np.ones(1)
    return (taps / taps.sum()).astype(np.float32)


@kernel
def blur(image, taps, between):
    """Convolve image (h, w) float32 in place along both axes; its border's values go on outside. between: scratch."""
    height, width = image.shape
    reach = len(taps) // 2
    for v in range(height):
        for u in range(width):
            between[v, u] = np.float32(0.0)
        for k in range(len(taps)):
            row, tap = min(max(v + k - reach, 0), height - 1), taps[k]
            for u in range(width):
                between[v, u] += tap * image[row, u]
    for v in range(height):
        for u in range(width):
            image[v, u] = np.float32(0.0)
        for k in range(len(taps)):
            shift, tap = k - reach, taps[k]
            low, high = min(max(-shift, 0), width), max(min(width - shift, width), 0)
            for u in range(low):
                image[v, u] += tap * between[v, 0]
            for u in range(low, high):
                image[v, u] += tap * between[v, u + shift]
            for u in range(high, width):
                image[v, u] += tap * between[v, width - 1]


class Particles(NamedTuple):
    """count: of them; box: (6,) north from and to, east from and to, down from and to [m], within which they drift.

    drift: (3,) their mean velocity, NED [m/s]; diameter [m]; level: in unit light [grey level];
    defocus: standard deviation of blur at twice or half the focused distance [pixel]; focus: that distance [m].
    """

    count: int
    box: np.ndarray
    drift: np.ndarray
    diameter: float
    level: float
    defocus: float
    focus: float


@kernel
def particle_at(particles, high, low, i, t, place):
    """Write particle i's position (3,) at t [s] into place; what leaves the box comes in at the other side."""
    own_n, own_e = uniform(high, low, DRIFT, i)
    own_d, _ = uniform(high, low, DRIFT + 1, i)
    for k in range(3):
        born, _ = uniform(high, low, BIRTH + k, i)
        own = own_n if k == 0 else (own_e if k == 1 else own_d)
        size = particles.box[2 * k + 1] - particles.box[2 * k]
        speed = sqrt(particles.drift[0] ** 2 + particles.drift[1] ** 2 + particles.drift[2] ** 2)
        way = born + (particles.drift[k] + SCATTER * speed * (2.0 * own - 1.0)) * t / size
        place[k] = particles.box[2 * k] + (way - floor(way)) * size


@kernel
def draw_particles(optics, particles, high, low, t, sigma, place, image):
    """Add the light of the particles at t [s], each a Gaussian as wide as lens, size and distance from the focus."""
    height, width = image.shape
    for i in range(particles.count):
        particle_at(particles, high, low, i, t, place)
        u0, v0, z = project(optics, place[0], place[1], place[2])
        if z <= 0.0:
            continue
        size = 0.25 * optics.f * particles.diameter / z  # a disc's second moment along an axis is its radius / 2
        away = particles.defocus * (particles.focus / z - 1.0)
        spread = sqrt(sigma * sigma + size * size + away * away)
        peak, reach = particles.level * 2.0 * size * size / (spread * spread), REACH * spread
        if not (-reach < u0 < width + reach and -reach < v0 < height + reach):
            continue
        for v in range(max(int(v0 - reach), 0), min(int(v0 + reach) + 2, height)):
            for u in range(max(int(u0 - reach), 0), min(int(u0 + reach) + 2, width)):
                square = ((u - u0) ** 2 + (v - v0) ** 2) / (spread * spread)
                image[v, u] += np.float32(peak * exp(-0.5 * square))


class Sensor(NamedTuple):
    """exposure: gain of all light; clear: share of it that passes the haze, whose own grey level is haze.

    noise: standard deviation without light [grey level]; shot: variance that a grey level adds [grey level].
    """

    exposure: float
    clear: float
    haze: float
    noise: float
    shot: float


@kernel
def expose(sensor, quantiles, high, low, frame, image, grey):
    """Write grey (h, w) uint8 from image (h, w) of light; frame: number of the image, for its noise.

    Eight pixels take the 128 bits of one draw, each the normal quantile of 16 of them.
    """
    height, width = image.shape
    blocks = (width + 7) // 8
    noisy = sensor.noise > 0.0 or sensor.shot > 0.0
    gain = np.float32(sensor.exposure * sensor.clear)
    veil = np.float32(sensor.exposure * (1.0 - sensor.clear) * sensor.haze)
    dark, shot = np.float32(sensor.noise * sensor.noise), np.float32(sensor.shot)
    half, top, zero = np.float32(0.5), np.float32(255.0), np.float32(0.0)
    for v in range(height):
        for block in range(blocks):
            a = b = c = d = np.uint64(0)
            if noisy:
                a, b, c, d = words(high, low, NOISE, (frame * height + v) * blocks + block)
            for k in range(min(8, width - 8 * block)):
                u = 8 * block + k
                value = gain * image[v, u] + veil
                if noisy:
                    word = a if k < 2 else (b if k < 4 else (c if k < 6 else d))
                    bits = (word >> np.uint64(16 * (k & 1))) & np.uint64(QUANTILES - 1)
                    value += np.float32(sqrt(dark + shot * max(value, zero))) * quantiles[bits]
                grey[v, u] = np.uint8(min(max(value + half, zero), top))
