"""A point of a line that is known at its nodes, in the world's plane and in a boat's."""

from math import cos, sin

from components.compiled import kernel
from components.placement import cell, weights


@kernel
def spot(nodes, segments, share):
    """North and east of the point at this share of the line from end a, by the cubic through the nodes around it."""
    first, f = cell(share * segments, segments)
    a, b, c, d = weights(f)
    n = 3 * first
    north = a * nodes[n] + b * nodes[n + 3] + c * nodes[n + 6] + d * nodes[n + 9]
    return north, a * nodes[n + 1] + b * nodes[n + 4] + c * nodes[n + 7] + d * nodes[n + 10]


@kernel
def seen_from(boat_north, boat_east, heading, north, east):
    """A point of the world ahead and to starboard of a boat."""
    dn, de = north - boat_north, east - boat_east
    return cos(heading) * dn + sin(heading) * de, cos(heading) * de - sin(heading) * dn
