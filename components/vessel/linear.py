"""A vessel's inertia and linear damping about zero speed: what a DP system knows of it."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from components.contract import Parameters, quantity


class LinearVessel(Parameters):
    """M nu' + D nu = tau in surge, sway and yaw; Fossen 2011, eq. 6.113."""

    surge_mass: float = quantity("kg", "m - X_u', added mass included", gt=0)
    sway_mass: float = quantity("kg", "m - Y_v'", gt=0)
    yaw_inertia: float = quantity("kg m^2", "I_z - N_r'", gt=0)
    sway_yaw_mass: float = quantity("kg m", "m x_g - Y_r', the same as m x_g - N_v'", 0.0)
    surge_damping: float = quantity("N s/m", "-X_u", 0.0)
    sway_damping: float = quantity("N s/m", "-Y_v", 0.0)
    sway_yaw_damping: float = quantity("N s", "-Y_r", 0.0)
    yaw_sway_damping: float = quantity("N s", "-N_v", 0.0)
    yaw_damping: float = quantity("N m s", "-N_r", 0.0)

    @model_validator(mode="after")
    def _is_a_body(self) -> LinearVessel:
        if self.sway_mass * self.yaw_inertia <= self.sway_yaw_mass**2:
            raise ValueError("sway_mass * yaw_inertia must be above sway_yaw_mass^2: the mass matrix is not positive")
        return self

    def mass_matrix(self) -> np.ndarray:
        """M: (3, 3) symmetric [kg, kg m, kg m^2]."""
        coupled = self.sway_yaw_mass
        return np.array([[self.surge_mass, 0, 0], [0, self.sway_mass, coupled], [0, coupled, self.yaw_inertia]])

    def damping_matrix(self) -> np.ndarray:
        """D: (3, 3) [N s/m, N s, N m s]."""
        return np.array(
            [
                [self.surge_damping, 0, 0],
                [0, self.sway_damping, self.sway_yaw_damping],
                [0, self.yaw_sway_damping, self.yaw_damping],
            ]
        )
