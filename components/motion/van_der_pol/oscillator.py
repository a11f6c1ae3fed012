"""The oscillator's equation and one step of the classical Runge-Kutta method (order 4)."""

from components.compiled import kernel


@kernel
def acceleration(x, v, neighbour, mu, kappa):
    """x'' [1/s^2] of x' = v; van der Pol 1926, with a linear spring to the neighbour."""
    return mu * (1.0 - x * x) * v - x + kappa * (neighbour - x)


@kernel
def runge_kutta(x, v, neighbour, mu, kappa, h):
    """(x, v) after h [s], the neighbour held."""
    a1 = acceleration(x, v, neighbour, mu, kappa)
    v2 = v + 0.5 * h * a1
    a2 = acceleration(x + 0.5 * h * v, v2, neighbour, mu, kappa)
    v3 = v + 0.5 * h * a2
    a3 = acceleration(x + 0.5 * h * v2, v3, neighbour, mu, kappa)
    v4 = v + h * a3
    a4 = acceleration(x + h * v3, v4, neighbour, mu, kappa)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
