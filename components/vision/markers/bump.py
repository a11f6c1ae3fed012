"""How a camera was shifted: the marks fixed in the tank, seen now against where they were seen at calibration."""

from math import inf

from components.compiled import kernel

AGREE = 2.0  # marks that moved alike within this belong together [pixel]


@kernel
def moved_alike(spots, count, marks, du, dv):
    """How many marks have a spot where the shift (du, dv) takes them."""
    alike = 0
    for j in range(len(marks)):
        for k in range(count):
            u, v = spots[k, 0] - marks[j, 0] - du, spots[k, 1] - marks[j, 1] - dv
            if u * u + v * v < AGREE * AGREE:
                alike += 1
                break
    return alike


@kernel
def find_shift(spots, count, marks, last, limit):
    """The shift (u, v) [pixel] that most marks (j, 2) agree on, of equal ones the nearest to the last; and how many do.

    spots: (room, >= 2) pixels, count of them; limit: how far the marks are looked for [pixel].
    """
    best, nearest, shift_u, shift_v = 0, inf, last[0], last[1]
    for j in range(len(marks)):
        for k in range(count):
            du, dv = spots[k, 0] - marks[j, 0], spots[k, 1] - marks[j, 1]
            if du * du + dv * dv > limit * limit:
                continue
            alike = moved_alike(spots, count, marks, du, dv)
            away = (du - last[0]) ** 2 + (dv - last[1]) ** 2
            if alike > best or (alike == best and away < nearest):
                best, nearest, shift_u, shift_v = alike, away, du, dv
    return shift_u, shift_v, best


@kernel
def rigid_shift(marks, seen, used, middle_u, middle_v):
    """Turn about (middle_u, middle_v) and shift, by least squares, that take the used marks (j, 2) to seen (j, 2).

    Angle to first order [rad], 0 with a single mark; u, v [pixel].
    """
    n = mu = mv = su = sv = 0.0
    for j in range(len(marks)):
        if used[j]:
            n += 1.0
            mu, mv = mu + marks[j, 0] - middle_u, mv + marks[j, 1] - middle_v
            su, sv = su + seen[j, 0] - middle_u, sv + seen[j, 1] - middle_v
    mu, mv, su, sv = mu / n, mv / n, su / n, sv / n
    top = below = 0.0
    for j in range(len(marks)):
        if used[j]:
            a, b = marks[j, 0] - middle_u - mu, marks[j, 1] - middle_v - mv
            c, d = seen[j, 0] - middle_u - su, seen[j, 1] - middle_v - sv
            top, below = top + a * d - b * c, below + a * a + b * b
    angle = top / below if n > 1.0 else 0.0
    return su - mu + angle * mv, sv - mv - angle * mu, angle
