"""Which spot is which marker: the best chain of spots along a line whose markers are known distances apart.

Dynamic programming over pairs of spots. A chain goes from marker to marker, leaves out those that are not seen, bends
by less than TURN between its links, and is worth GAIN a marker less half the squared deviations from what is expected
where, and of the links' lengths. What is expected keeps identities through an occlusion; order and distances along the
line refuse a false spot, and start a chain where nothing is expected yet.
"""

from math import cos, inf, sqrt
from typing import NamedTuple

import numpy as np

from components.compiled import kernel

GAIN = 8.0  # of a marker: one that is 4 standard deviations from where it is expected is worth nothing
LEAP = 6  # markers at most that a link spans
TURN = cos(1.1)  # of neighbouring links, 63 degrees
SLACK = 0.03  # by which a link may be longer than along the line: error of the scales, with that of the spots
CURVED = 0.02  # a link of g spacings may be shorter than along the line by this times (1 + g)^2 of it, at most
SHORTEST = 0.3  # and by no more than down to this share
DEVIATION = 0.03  # of a link's length, of the shortfall that a curve does not explain
ROOM = 64, 4096  # spots and links
ALONE = -2  # in place of a link: the chain ends with a marker that is not linked


class Links(NamedTuple):
    """From and to: spots; gap: spacings between them. Each (room,) int64, `worth` (room,) float64, at most 0.

    Links are ordered by the spot they end at: those of spot b begin at of_end[b].
    """

    start: np.ndarray
    end: np.ndarray
    gap: np.ndarray
    worth: np.ndarray
    of_end: np.ndarray


class Chains(NamedTuple):
    """Best chains that end with a link at a marker: (m, ROOM) worth and the link before, -1 none or -2 - k at marker k.

    last: (m,) worth of the best chain that ends at this marker or before, and last_link, last_marker (m,) its end.
    """

    worth: np.ndarray
    before: np.ndarray
    last: np.ndarray
    last_link: np.ndarray
    last_marker: np.ndarray


def empty_links() -> Links:
    """Room for links."""
    start, end, gap = (np.empty(ROOM[1], np.int64) for _ in range(3))
    return Links(start, end, gap, np.empty(ROOM[1]), np.empty(ROOM[0] + 1, np.int64))


def empty_chains(markers: int) -> Chains:
    """Room for chains of this many markers."""
    worth, before = np.empty((markers, ROOM[1])), np.empty((markers, ROOM[1]), np.int64)
    return Chains(worth, before, np.empty(markers), np.empty(markers, np.int64), np.empty(markers, np.int64))


@kernel
def link_worth(length, gap, spacing, deviation):
    """Worth of a link, -inf if the line cannot span it; deviation: of the length by the spots' errors [m]."""
    along = gap * spacing
    shortest = max(1.0 - CURVED * (1.0 + gap) ** 2, SHORTEST) * along
    if length > (1.0 + SLACK) * along + 3.0 * deviation or length < shortest - 3.0 * deviation:
        return -inf
    over = max(length - along, 0.0) / (DEVIATION * spacing + deviation)
    under = max(along - length, 0.0) / (2.0 * DEVIATION * along + deviation)
    return -0.5 * (over * over + under * under)


@kernel
def make_links(spots, count, spacing, deviation, links):
    """Write all links between the spots (count, 2) [m]; how many."""
    n = 0
    for b in range(count):
        links.of_end[b] = n
        for a in range(count):
            if a == b:
                continue
            length = sqrt((spots[b, 0] - spots[a, 0]) ** 2 + (spots[b, 1] - spots[a, 1]) ** 2)
            for gap in range(1, LEAP + 1):
                worth = link_worth(length, gap, spacing, deviation)
                if worth > -GAIN and n < len(links.start):
                    links.start[n], links.end[n], links.gap[n], links.worth[n] = a, b, gap, worth
                    n += 1
    links.of_end[count] = n
    return n


@kernel
def turns_little(spots, a, b, c):
    """Whether the links from a to b and b to c bend by less than TURN allows."""
    ux, uy, vx, vy = (
        spots[b, 0] - spots[a, 0],
        spots[b, 1] - spots[a, 1],
        spots[c, 0] - spots[b, 0],
        spots[c, 1] - spots[b, 1],
    )
    return ux * vx + uy * vy > TURN * sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy))


@kernel
def spot_worth(spots, k, expected, deviation, i):
    """Worth of spot k as marker i; -inf beyond 4 deviations [m], GAIN alone where nothing is expected (inf)."""
    if deviation[i] == inf:
        return GAIN
    n, d = (spots[k, 0] - expected[i, 0]) / deviation[i], (spots[k, 1] - expected[i, 1]) / deviation[i]
    worth = GAIN - 0.5 * (n * n + d * d)
    return worth if worth > 0.0 else -inf


@kernel
def reaches(spots, k, i, expected, deviation, spacing):
    """Whether spot k can be marker i of a chain that begins there, marker 0 being expected somewhere but not seen."""
    if deviation[i] < inf or i == 0 or deviation[0] == inf:
        return True
    n, d = spots[k, 0] - expected[0, 0], spots[k, 1] - expected[0, 1]
    return link_worth(sqrt(n * n + d * d), i, spacing, deviation[0]) > -inf


@kernel
def last_spot(links, chains, single, i):
    """Spot that the best chain up to marker i ends at, -1 without one."""
    if i < 0 or chains.last_marker[i] < 0:
        return -1
    link = chains.last_link[i]
    return single[chains.last_marker[i]] if link == ALONE else links.end[link]


@kernel
def worth_before(spots, k, i, spacing, links, chains, single):
    """Worth of the best chain that may go before a chain anew from spot k as marker i; 0 for none.

    It ends farther off than a link spans, or it would be linked, and no farther than the line is long.
    """
    a = last_spot(links, chains, single, i - 1)
    if a < 0:
        return 0.0
    gap = i - chains.last_marker[i - 1]
    length = sqrt((spots[k, 0] - spots[a, 0]) ** 2 + (spots[k, 1] - spots[a, 1]) ** 2)
    if a == k or gap <= LEAP or length > (1.0 + SLACK) * gap * spacing:
        return 0.0
    return chains.last[i - 1]


@kernel
def fill_chains(spots, count, links, n_links, expected, deviation, spacing, single, chains):
    """Work out the best chain to every link at every marker. single: (m,) spot best as this marker alone, or -1."""
    for i in range(len(deviation)):
        best, link, marker = 0.0, -1, -1
        if i > 0:
            best, link, marker = chains.last[i - 1], chains.last_link[i - 1], chains.last_marker[i - 1]
        single[i] = -1
        for e in range(n_links):
            chains.worth[i, e], gap, a, b = -inf, links.gap[e], links.start[e], links.end[e]
            k = i - gap
            own = spot_worth(spots, b, expected, deviation, i) if k >= 0 else -inf
            if own == -inf:
                continue
            value, before = -inf, -1
            for f in range(links.of_end[a], links.of_end[a + 1]):
                if chains.worth[k, f] > value and turns_little(spots, links.start[f], a, b):
                    value, before = chains.worth[k, f], f
            first = spot_worth(spots, a, expected, deviation, k)
            if first > -inf and reaches(spots, a, k, expected, deviation, spacing):
                ahead = worth_before(spots, a, k, spacing, links, chains, single) if deviation[k] < inf else 0.0
                if first + ahead > value:
                    value, before = first + ahead, (-2 - (k - 1) if ahead > 0.0 else -1)
            if value == -inf:
                continue
            chains.worth[i, e], chains.before[i, e] = value + own + links.worth[e], before
            if chains.worth[i, e] > best:
                best, link, marker = chains.worth[i, e], e, i
        if deviation[i] < inf:
            for k in range(count):
                worth = spot_worth(spots, k, expected, deviation, i)
                worth += worth_before(spots, k, i, spacing, links, chains, single)
                if worth > best:
                    best, link, marker, single[i] = worth, ALONE, i, k
        chains.last[i], chains.last_link[i], chains.last_marker[i] = best, link, marker


@kernel
def read_back(spots, spacing, links, chains, single, taken):
    """Write the spot of each marker into taken (m,), -1 where it is not seen; the whole worth."""
    for i in range(len(taken)):
        taken[i] = -1
    at = len(taken) - 1
    while at >= 0 and chains.last_marker[at] >= 0:
        i, e = chains.last_marker[at], chains.last_link[at]
        if e == ALONE:
            taken[i] = single[i]
            at = i - 1 if worth_before(spots, single[i], i, spacing, links, chains, single) > 0.0 else -1
            continue
        while e >= 0:
            taken[i] = links.end[e]
            k, before = i - links.gap[e], chains.before[i, e]
            if before < 0:
                taken[k] = links.start[e]
                at = -before - 2 if before <= -2 else -1
                break
            i, e = k, before
    return chains.last[len(taken) - 1]


@kernel
def assign(spots, count, spacing, error, expected, deviation, links, chains, single, taken):
    """Give each marker its spot.

    spots: (room, 2), count of them [m]; error: their standard deviation [m]; expected: (m, 2) [m], deviation: (m,) of
    it [m], inf where nothing is expected; single: (m,) int64 scratch; taken: (m,) int64 written: spot or -1.
    A spot may come out twice, far apart along the line: the caller refuses it at the marker where it fits less.
    """
    n_links = make_links(spots, count, spacing, error, links)
    fill_chains(spots, count, links, n_links, expected, deviation, spacing, single, chains)
    return read_back(spots, spacing, links, chains, single, taken)
