"""The three filters of a line on odd numbers: what they say is finite, or a status says in one line why not."""

import numpy as np
import pytest

from components.compiled import functions
from components.estimator.best.component import COMPONENT as BEST
from components.estimator.corrected.component import COMPONENT as CORRECTED
from components.estimator.published.component import COMPONENT as PUBLISHED

H, CASES, FRAMES = 0.036, 40, 40
ODD = np.array([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 0.0])
ARGUMENTS = {"corrected": CORRECTED, "best": BEST, "published": PUBLISHED}


def some(rng, low, high):
    """A positive number of any size."""
    return float(10.0 ** rng.uniform(low, high))


def parameters_of(component, rng):
    """Any that the component takes."""
    n, first = int(rng.choice([1, 2, 3, 5, 8])), int(rng.integers(2))
    length = some(rng, -1, 2)
    l = length / n
    given = {
        "length": length, "bars": n, "spacing": l, "first": first * l, "markers": int(rng.integers(1, n + 2 - first)),
        "mass_per_length": some(rng, -3, 3), "weight": float(rng.choice([0, 1, -1])) * some(rng, -2, 2),
        "flexural_rigidity": float(rng.integers(2)) * some(rng, -8, 3), "clamp": bool(rng.integers(2)),
        "normal_friction": float(rng.integers(2)) * some(rng, -3, 3), "marker_noise": some(rng, -12, 0),
        "takes_covariance": bool(rng.integers(2)), "start_angle": some(rng, -6, 1), "start_rate": some(rng, -6, 2),
        "angles": tuple(rng.uniform(-1.5, 1.5, n)) if rng.integers(2) else (),
    }  # fmt: skip
    if component is PUBLISHED:
        given |= {"force_variance": some(rng, -12, 6), "angle_variance": some(rng, -18, 2)}
        given |= {"start_variance": some(rng, -12, 6), "start_tension": float(rng.choice([0.0, -5.0, 1e6]))}
    elif component is CORRECTED:
        given |= {"force_noise": some(rng, -8, 4), "start_force": some(rng, -6, 3)}
    else:
        given |= {"end_force": (some(rng, -2, 2), -some(rng, -2, 2)), "end_force_spread": some(rng, -3, 2)}
        given |= {"end_force_time": some(rng, -2, 3), "moment_noise": some(rng, -5, 1), "gyros": (0.3 * length,)}
        given |= {"end_position_noise": some(rng, -4, 0), "end_tension_noise": some(rng, -4, 0), "tilts": (length,)}
        given |= {"pivot": str(rng.choice(["fixed", "moving"])), "drag_diameter": some(rng, -3, 0)}
    given |= {} if component is BEST else {"interval": H}
    return component.parameters(**given)


def frames(line, size, rng):
    """Inputs of a line that stands, moves, jumps, is scattered over all sizes, or lies in one point."""
    n, first, m = line.bars, round(line.first / line.bar), line.markers
    angles = np.cumsum(0.3 * rng.standard_normal(n))
    way = rng.choice(["stands", "moves", "jumps", "scattered", "point"])
    seen = rng.choice([1.0, 0.9, 0.3, 0.0], p=[0.6, 0.2, 0.1, 0.1])
    for _ in range(FRAMES):
        angles = angles + (0.0 if way == "stands" else 0.01) * rng.standard_normal(n)
        if way == "jumps" and rng.random() < 0.1:
            angles = rng.uniform(-4.0, 4.0, n)
        t = line.bar * np.column_stack([np.cos(angles), np.sin(angles)])
        nodes = np.vstack([np.zeros(2), np.cumsum(t, axis=0)])[first : first + m]
        position = np.zeros((m, 3))
        position[:, [0, 2]] = nodes * (10.0 ** rng.uniform(-8, 12, (m, 1)) if way == "scattered" else 1.0)
        u = rng.standard_normal(size)
        u[: 3 * m] = position.ravel() * (0.0 if way == "point" else 1.0)
        u[3 * m : 4 * m] = rng.random(m) < seen
        if line.takes_covariance:
            u[4 * m : 8 * m] = np.tile(line.marker_noise**2 * np.eye(2).ravel(), m)
        if rng.random() < 0.1:
            u[rng.integers(0, size, 2)] = rng.choice(ODD, 2)
        yield u


@pytest.mark.parametrize("name", ARGUMENTS)
def test_finite_or_told(name):
    component, ended = ARGUMENTS[name], 0
    init, step = functions(component)
    for case in range(CASES):
        rng = np.random.default_rng(case)
        line = parameters_of(component, rng)
        p = component.pack(line)
        u, x, y, w = (np.full(int(k), np.nan) for k in p[1:5])
        for k, values in enumerate(frames(line, len(u), rng)):
            u[:] = values
            y[:] = w[:] = np.nan
            if status := (step if k else init)(k * 36_000_000, 36_000_000, p, u, x, y, w):
                assert len(component.status_text[status]) > 30
                ended += 1
                break
            assert np.isfinite(y).all(), f"case {case}, frame {k}"
            assert np.isfinite(x).all(), f"case {case}, frame {k}"
    # As printed it may lose its covariance's definiteness; the others hardly ever end, and `corrected` never.
    assert ended <= {"corrected": 0, "best": CASES // 10, "published": CASES // 4}[name]


def test_variances_tiny_beside_the_estimates_are_told():
    # (33) subtracts: P - K H P of 1e6 with R of 1e-18 has no digit left.
    line = {"length": 1.0, "bars": 2, "mass_per_length": 0.2, "weight": 0.1, "spacing": 0.5, "marker_noise": 1e-3}
    line |= {"markers": 3}
    p = PUBLISHED.pack(
        PUBLISHED.parameters(**line, interval=H, angle_variance=1e-18, start_variance=1e6, force_variance=1e-6)
    )
    u, x, y, w = (np.zeros(int(k)) for k in p[1:5])
    u[:12] = [0.0, 0.0, 0.0, 0.5, 0.0, 0.01, 1.0, 0.0, 0.03, 1.0, 1.0, 1.0]
    init, step = functions(PUBLISHED)
    statuses = [init(0, 36_000_000, p, u, x, y, w)]
    while statuses[-1] == 0 and len(statuses) < 100:
        statuses.append(step(36_000_000 * len(statuses), 36_000_000, p, u, x, y, w))
    assert "raise it" in PUBLISHED.status_text[statuses[-1]]


def test_one_bar_and_a_straight_line_tell_no_tension_as_printed(unit):
    line = {"length": 1.0, "mass_per_length": 0.2, "weight": 0.1, "marker_noise": 1e-3, "interval": H}
    for bars in (1, 2):
        u = np.zeros(4 * (bars + 1))
        u[: 3 * bars + 3 : 3] = np.linspace(0.0, 1.0, bars + 1)
        u[3 * bars + 3 :] = 1.0
        riser = unit("estimator.published", u, h=H, **line, bars=bars, markers=bars + 1, spacing=1.0 / bars)
        assert riser["deviation.end_tension"] == 1e9
