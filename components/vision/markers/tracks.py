"""Where each marker is expected in the next image, and how surely: what the identities rest on.

A seen marker goes on with its velocity. One that is not seen goes with its neighbours along the line, and is expected
less and less surely, up to the distance that a line wanders; so a line that comes back after seconds is known again if
its markers are nearer to where they were than to where their neighbours were.
"""

from __future__ import annotations

from math import exp

import numpy as np

# A marker's record in x: place [m], velocity [m/s], both north and down, and the time it was not seen [s].
PLACE, VELOCITY, UNSEEN, TRACK = slice(0, 2), slice(2, 4), 4, 5
NEVER = -1.0  # of UNSEEN
FORGOTTEN = 0.3  # time constant in which the velocity of an unseen marker decays [s]
SHARE = 0.5  # of a new velocity in the kept one
LEAST = 0.004  # standard deviation of what is expected a moment after it was seen [m]


def forget(x: np.ndarray) -> None:
    """No marker (m, TRACK) was seen yet."""
    x[:] = 0.0
    x[:, UNSEEN] = NEVER


def expect(
    x: np.ndarray, h: float, agility: float, wander: float, first: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """What is expected h [s] after the last image: (m, 2) [m], and its standard deviation (m,) [m], inf for nothing.

    agility: acceleration of a marker [m/s^2]; wander: largest deviation [m]; first: (2,) where marker 0 is looked for
    while it was not seen, tolerance: its standard deviation [m].
    """
    age = x[:, UNSEEN] + h
    expected = x[:, PLACE] + h * x[:, VELOCITY]
    deviation = np.minimum(np.hypot(LEAST, 0.5 * agility * age * age), wander)
    never = x[:, UNSEEN] == NEVER
    deviation[never] = np.inf
    if never[0]:
        expected[0], deviation[0] = first, tolerance
    return expected, deviation


def go_on(x: np.ndarray, places: np.ndarray, seen: np.ndarray, h: float) -> None:
    """The markers seen (m,) bool are at places (m, 2) [m], h [s] after the last image; the others follow them."""
    before = x[:, PLACE].copy()
    again = seen & (x[:, UNSEEN] == 0.0) & (h > 0.0)
    x[again, VELOCITY] += SHARE * ((places[again] - x[again, PLACE]) / max(h, 1e-12) - x[again, VELOCITY])
    x[seen & ~again, VELOCITY] = 0.0
    x[seen, PLACE], x[seen, UNSEEN] = places[seen], 0.0
    lost = ~seen & (x[:, UNSEEN] != NEVER)
    x[lost, VELOCITY] *= exp(-h / FORGOTTEN)
    moves = h * x[:, VELOCITY]
    there, index = np.flatnonzero(again), np.arange(len(x))
    if len(there) > 1:
        between = lost & (index > there[0]) & (index < there[-1])
        for c in range(2):
            x[between, VELOCITY.start + c] = np.interp(index[between], there, x[there, VELOCITY.start + c])
            moves[between, c] = np.interp(index[between], there, (places - before)[there, c])
    x[lost, PLACE] += moves[lost]
    x[lost, UNSEEN] += h
