"""Long-crested Airy waves: the motion of the water as the sum of linear components."""

from math import cos, exp, sin, sqrt, tanh

from components.compiled import kernel

WAVE = 6  # numbers of a component: amplitude [m], omega [rad/s], k [rad/m], north and east of its way, phase [rad]
# A water depth beside which any wave is short [m].
DEEP = 1e30
# Newton on the dispersion relation squares its error at each step; from Eckart's approximation, within 5 %, six
# reach rounding.
_NEWTON = 8


@kernel
def wave_number(omega, depth, gravity):
    """k [rad/m] of omega^2 = g k tanh(k d): Airy 1845; Newton from Eckart's k (1952). depth: [m], DEEP if deep."""
    deep = omega * omega / gravity
    if deep * depth > 40.0:  # 1 - tanh(40) is below rounding
        return deep
    k = deep / sqrt(tanh(deep * depth))
    for _ in range(_NEWTON):
        t = tanh(k * depth)
        k -= (k * t - deep) / (t + k * depth * (1.0 - t * t))
    return k


@kernel
def elevation(table, at, north, east, t):
    """Surface above its mean level [m]: sum of a cos(k x - omega t + phase), x along each component's way."""
    eta = 0.0
    k = at + 2
    for _ in range(int(table[at])):
        eta += table[k] * cos(
            table[k + 2] * (table[k + 3] * north + table[k + 4] * east) - table[k + 1] * t + table[k + 5]
        )
        k += WAVE
    return eta


@kernel
def orbit(table, at, north, east, depth, t):
    """Velocity (3) [m/s] and local acceleration (3) [m/s^2] of the water, NED, at a depth [m] below the mean surface.

    table[at]: number of components, table[at + 1]: water depth d [m]; then the components. Linear theory (Airy 1845;
    Faltinsen 1990, table 2.1), stretched to the moving surface by Wheeler 1970 (J. Petroleum Technology 22): the
    height zeta is replaced by d (zeta - eta) / (d + eta), so that the orbits reach the surface and no farther; above
    it they are the surface's.
    """
    d = table[at + 1]
    eta = elevation(table, at, north, east, t)
    height = min(d * (-depth - eta) / (d + eta), 0.0)
    vn = ve = vd = an = ae = ad = 0.0
    k = at + 2
    for _ in range(int(table[at])):
        a, omega, number, cn, ce = table[k], table[k + 1], table[k + 2], table[k + 3], table[k + 4]
        theta = number * (cn * north + ce * east) - omega * t + table[k + 5]
        down, up = exp(number * height), exp(-number * (height + 2.0 * d))
        speed = a * omega / (1.0 - exp(-2.0 * number * d))
        level, rise = speed * (down + up), speed * (down - up)
        c, s = cos(theta), sin(theta)
        vn, ve, vd = vn + level * c * cn, ve + level * c * ce, vd - rise * s
        an, ae, ad = an + omega * level * s * cn, ae + omega * level * s * ce, ad + omega * rise * c
        k += WAVE
    return vn, ve, vd, an, ae, ad
