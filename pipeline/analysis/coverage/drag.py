"""Laws of drag on a floating line that is towed across the water."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, sin


@dataclass(frozen=True)
class Drag:
    """Force per length c v^power (across n, along t), over an element whose normal is turned by phi from the tow.

    power: 1, Bhattacharya et al. 2011, eq. 1, c = c_S [N s/m^2]; 2, with c = rho d C_D / 2 [N s^2/m^3], where each
    part of the velocity makes its own force (as Morison's), or all of it one against itself (`is_isotropic`).
    ratio: the coefficient along over that across; of an isotropic drag 1.
    """

    name: str
    power: int
    ratio: float
    is_isotropic: bool = False

    def __post_init__(self):
        """Raises ValueError for a law that is none."""
        if self.power not in (1, 2):
            raise ValueError(f"power is {self.power}; expected 1 or 2")
        if not 0.0 <= self.ratio <= 1.0:
            raise ValueError(f"ratio is {self.ratio:g}; expected 0 to 1: the drag along a line is the smaller one")
        if self.is_isotropic and self.ratio != 1.0:
            raise ValueError(f"ratio is {self.ratio:g}; of an isotropic drag it is 1")

    def parts(self, phi: float) -> tuple[float, float]:
        """Across and along, each over c v^power, against the tow."""
        v_n, v_t = cos(phi), sin(phi)
        if self.power == 1 or self.is_isotropic:
            size = hypot(v_n, v_t) ** (self.power - 1)
            return size * v_n, self.ratio * size * v_t
        return abs(v_n) * v_n, self.ratio * abs(v_t) * v_t


EQUAL = Drag("linear, c_V = c_S", 1, 1.0)
ACROSS = Drag("linear, c_V = 0", 1, 0.0)
QUADRATIC_ACROSS = Drag("quadratic, across only", 2, 0.0)
QUADRATIC = Drag("quadratic, isotropic", 2, 1.0, is_isotropic=True)
LAWS = (EQUAL, ACROSS, QUADRATIC_ACROSS, QUADRATIC)
