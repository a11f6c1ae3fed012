"""Where each marker is expected in the next image, and how surely: what the identities rest on.

A seen marker goes on with its velocity. One that is not seen goes with its neighbours along the line, and is expected
less and less surely, up to the distance that a line wanders; so a line that comes back after seconds is known again if
its markers are nearer to where they were than to where their neighbours were.
"""

from math import exp, inf, sqrt

from components.compiled import kernel

NORTH, DOWN, V_NORTH, V_DOWN, UNSEEN, TRACK = 0, 1, 2, 3, 4, 5  # a marker's record in x: [m], [m/s], time unseen [s]
NEVER = -1.0  # of UNSEEN
FORGOTTEN = 0.3  # time constant in which the velocity of an unseen marker decays [s]
SHARE = 0.5  # of a new velocity in the kept one
LEAST = 0.004  # standard deviation of what is expected a moment after it was seen [m]


@kernel
def forget(x):
    """No marker was seen yet."""
    for i in range(len(x)):
        for c in range(TRACK):
            x[i, c] = 0.0
        x[i, UNSEEN] = NEVER


@kernel
def expect(x, h, agility, wander, first, tolerance, expected, deviation):
    """Write what is expected h [s] after the last image into expected (m, 2) [m] and deviation (m,) [m].

    x: (m, TRACK); agility: acceleration of a marker [m/s^2]; wander: largest deviation [m]; first: (2,) where marker 0
    is to be looked for while nothing was seen, tolerance: its standard deviation [m].
    """
    for i in range(len(x)):
        if x[i, UNSEEN] == NEVER:
            expected[i, 0], expected[i, 1] = first[0], first[1]
            deviation[i] = tolerance if i == 0 else inf
            continue
        age = x[i, UNSEEN] + h
        expected[i, 0], expected[i, 1] = x[i, NORTH] + h * x[i, V_NORTH], x[i, DOWN] + h * x[i, V_DOWN]
        deviation[i] = min(sqrt(LEAST * LEAST + (0.5 * agility * age * age) ** 2), wander)


@kernel
def see(x, i, north, down, h):
    """Marker i is seen at (north, down) [m], h after the last image."""
    if x[i, UNSEEN] == 0.0 and h > 0.0:
        x[i, V_NORTH] += SHARE * ((north - x[i, NORTH]) / h - x[i, V_NORTH])
        x[i, V_DOWN] += SHARE * ((down - x[i, DOWN]) / h - x[i, V_DOWN])
    elif x[i, UNSEEN] != NEVER or h == 0.0:
        x[i, V_NORTH] = x[i, V_DOWN] = 0.0
    x[i, NORTH], x[i, DOWN], x[i, UNSEEN] = north, down, 0.0


@kernel
def neighbour(x, i, by):
    """The next marker that is seen now, in steps of by; -1 if there is none."""
    i += by
    while 0 <= i < len(x):
        if x[i, UNSEEN] == 0.0:
            return i
        i += by
    return -1


@kernel
def miss(x, i, h):
    """Marker i is not seen; to be called after see() of the others."""
    if x[i, UNSEEN] == NEVER:
        return
    a, b = neighbour(x, i, -1), neighbour(x, i, 1)
    keep = exp(-h / FORGOTTEN)
    for c in (V_NORTH, V_DOWN):
        if a >= 0 and b >= 0:
            x[i, c] = ((b - i) * x[a, c] + (i - a) * x[b, c]) / (b - a)
        else:
            x[i, c] *= keep
    x[i, NORTH] += h * x[i, V_NORTH]
    x[i, DOWN] += h * x[i, V_DOWN]
    x[i, UNSEEN] += h
