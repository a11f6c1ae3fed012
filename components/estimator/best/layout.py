"""Where the chain filter's numbers lie in p, its states in x, and its tables in the scratch vector.

State: the bars' angles and rates (n each), loads (force on the free end, and where the pivot moves its acceleration;
two each), and where the pivot moves its position and velocity (two each). Behind it in x: the root of its covariance
(N, N), of each reading how many frames in a row it was refused, and what is kept of contradictions.
"""

from typing import NamedTuple

from components.compiled import kernel
from components.contract import HEADER
from components.tether.linkage.lagrangian import size

(MARKERS, TILTS, GYROS, MOVES, GATE, MARKER_VARIANCE, TAKES_COVARIANCE, CHAIN_VARIANCE, NORTH, EAST, DOWN, GIVEN,
 P_ANGLE, P_RATE, TORQUE, FORCE_NORTH, FORCE_DOWN, FORCE_SPREAD, FORCE_TIME, PIVOT_SPREAD, PIVOT_TIME, P_PLACE, P_SPEED,
 END_VARIANCE, TENSION_VARIANCE, TILT_VARIANCE, GYRO_VARIANCE, ITERATIONS, BELIEVED_AFTER, BARS,
) = range(HEADER, HEADER + 30)  # fmt: skip
TABLES = HEADER + 30  # angles (n), places of markers (m), tilts and gyros, then the chain's constants
# A reading's record: what it is, where on the line, its numbers (2), the lower root of their covariance (3), whether it
# is used, and its innovation's normalised square.
KIND, WHERE, VALUE, ROOT, STATUS, SQUARE, READING = 0, 1, 2, 4, 7, 8, 9
PLACE, TENSION, TILT, GYRO = range(4)


class Layout(NamedTuple):
    """n bars, N states, `loads` of them loads, K noises, R readings; then indices, the first three into the state.

    In w: Phi and the noise's columns (N, N + K), a matrix of that size, one of (N, N), the columns (n, 3 n + 6) that a
    step is solved for, of all readings
    the rows (2 R, N) and what they make of the root (2 R, N), rows (6, N), the readings' records, what is derived, and
    the chain's slopes.
    """

    n: int
    N: int
    loads: int
    K: int
    R: int
    F: int
    place: int
    speed: int
    moves: int
    wide: int
    before: int
    columns: int
    rows: int
    spare: int
    records: int
    derived: int
    slopes: int


@kernel
def layout(n, moves, R):
    """For n bars, a pivot that moves or not, and R readings."""
    loads = 4 if moves else 2
    N, K = 2 * n + loads + (4 if moves else 0), n + loads
    place = 2 * n + loads
    wide = N * (N + K)
    before = 2 * wide
    columns = before + N * N
    rows = columns + n * (3 * n + 6)
    spare = rows + 4 * R * N
    records = spare + 6 * N
    derived = records + READING * R
    return Layout(
        n, N, loads, K, R, 2 * n, place, place + 2, 0, wide, before, columns, rows, spare, records, derived,
        derived + 16 * n + 4 + 2 * R,
    )  # fmt: skip


def workspace(room: Layout) -> int:
    """Numbers of scratch in all."""
    return room.slopes + size(room.n)


@kernel
def layout_of(p):
    """The layout for the numbers in p."""
    sensors = (1 if p[END_VARIANCE] > 0.0 else 0) + (1 if p[TENSION_VARIANCE] > 0.0 else 0)
    return layout(int(p[BARS]), p[MOVES] > 0.0, int(p[MARKERS]) + int(p[TILTS]) + int(p[GYROS]) + sensors)


@kernel
def tables_of(p):
    """Where the angles at t0, the places of markers, tilts and gyros, and the chain's constants begin in p."""
    angles = TABLES + int(p[BARS])
    return TABLES, angles, angles + int(p[MARKERS]) + int(p[TILTS]) + int(p[GYROS])
