"""What one line-dynamics case is, in the same words for every code, and what a run of it leaves behind."""

from dataclasses import dataclass, field
from math import pi

import numpy as np

from components.motion.ellipse.orbit import orbit

GRAVITY = 9.80665
BOTTOMLESS = 1e4  # depth given to a peer where the case has no sea bed [m]
POINTS = 10  # positions are compared at the material points s = L k / 10


@dataclass(frozen=True)
class Seabed:
    """Flat, at a depth [m]; a normal pressure of stiffness x indentation + damping x its rate on the diameter."""

    depth: float
    stiffness: float  # [Pa/m]
    damping: float  # [Pa s/m]


@dataclass(frozen=True)
class Case:
    """A uniform line from a fixed end (a) to one that goes round an ellipse (b); NED, SI.

    damping: BA of T = EA e + BA de/dt [N s]. Drag and added mass on the diameter, the tangential drag on its
    circumference: rho d C_n |v_n| v_n / 2 + rho pi d C_t |v_t| v_t / 2.
    sample: spacing of the instants that are compared [s]; skipped: how many of the first are not.
    """

    name: str
    length: float
    mass: float  # dry [kg/m]
    diameter: float
    stiffness: float  # EA [N]
    damping: float
    fixed: tuple[float, float, float]
    centre: tuple[float, float, float]
    cosine: tuple[float, float, float]
    sine: tuple[float, float, float]
    frequency: float
    ramp: float
    duration: float
    sample: float
    drag_n: float = 1.2
    drag_t: float = 0.05
    added_n: float = 1.0
    added_t: float = 0.0
    density: float = 1000.0
    bending: float = 0.0  # EI [N m^2]
    relax: int = 0  # pseudo-time of MoorDyn's dynamic relaxation, where its static solver finds no equilibrium [s]
    current: float = 0.0  # along north, the same at all depths [m/s]
    seabed: Seabed | None = None

    @property
    def area(self) -> float:
        """Displaced volume per length [m^2]."""
        return pi / 4 * self.diameter**2

    def times(self, step: float) -> np.ndarray:
        """Every instant of a run with this step [s]: (k + 1,)."""
        return np.arange(round(self.duration / step) + 1) * step

    def moving_end(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity, acceleration of end b, NED, each (k, 3)."""
        c, dc, ddc, s, ds, dds = np.array([orbit(t, self.frequency, self.ramp) for t in times]).T
        along, across = np.array(self.cosine), np.array(self.sine)
        return (
            np.array(self.centre) + np.outer(c, along) + np.outer(s, across),
            np.outer(dc, along) + np.outer(ds, across),
            np.outer(ddc, along) + np.outer(dds, across),
        )


@dataclass(frozen=True)
class Trace:
    """A run's samples: tension at ends a and b (k, 2) [N], material points (k, POINTS + 1, 3) NED [m].

    loop_s: processor time of the time loop alone, which is wall time on a machine with nothing else to do; call_s: of
    the loop and the equilibrium before it, input read.
    """

    tension: np.ndarray
    points: np.ndarray
    loop_s: float
    call_s: float
    extra: dict[str, float] = field(default_factory=dict)


def flipped(vectors: np.ndarray) -> np.ndarray:
    """Between NED and the peers' axes (north, west, up): a turn by 180 degrees about north, its own inverse."""
    return vectors * np.array([1.0, -1.0, -1.0])
