"""What the wind meets on a vessel: its parameters, as wind_load.py takes them."""

from __future__ import annotations

from components.contract import Parameters, quantity

AIR = 1.247  # dry, at 10 degC and 1013 hPa [kg/m^3]


class Windage(Parameters):
    """What the wind meets, and Blendermann's (1994) coefficients."""

    frontal_area: float = quantity("m^2", "seen from ahead", gt=0)
    lateral_area: float = quantity("m^2", "seen from the side", gt=0)
    length: float = quantity("m", "length overall", gt=0)
    centroid: float = quantity("m", "of the lateral area, ahead of the reference point", 0.0)
    cross: float = quantity("1", "C_D,t, from the side", gt=0)
    ahead: float = quantity("1", "C_D,l,AF, from ahead", gt=0)
    astern: float = quantity("1", "C_D,l,AF, from astern", gt=0)
    shape: float = quantity("1", "delta, cross-force parameter", ge=0, lt=1)


def windage_numbers(windage: Windage | None, air_density: float) -> list[float]:
    """The numbers of wind_load.blow; of no windage, such as make no load."""
    if windage is None:
        return [0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    a, half = windage, 0.5 * air_density
    shape = [a.cross, a.ahead, a.astern, a.shape]
    return [half * a.frontal_area, half * a.lateral_area, a.length, a.centroid / a.length, *shape]
