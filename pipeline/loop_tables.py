"""What the compiled loop reads and writes: one tuple of flat arrays, and the names of their columns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Columns of Tables.nodes. Addresses are machine addresses, the rest are indices and counts. N_Y: numbers on the board;
# WIDTH: these and the images behind them, whose bytes stand there as float64 that nothing computes with.
(STEP, P, U, X, Y, W, DT_NS, PERIOD, BOARD, N_Y, STATE, N_X, FIRST_TERM, END_TERM, WIDTH, OFFSET_ON) = range(16)
# Columns of Tables.terms.
TARGET, SOURCE, COUNT, OFFSET, ASSIGNS = range(5)
# Columns of Tables.bonds; the last four are graph.OtherEnd's, OTHER -1 where there is none.
(LINE, BODY, MOTION, ACCEPTED, BODY_LAW, ROUNDS, BOND_CAPTURE, OTHER, CROSS, OTHER_FIRST, ACCELERANCE) = range(11)
# Columns of Tables.bond_energy: the attachment's last position, energies, and counts.
LAST_POSITION, RESIDUAL, THROUGHPUT, REPEATS, UNCONVERGED, BOND_STATE = 0, 3, 4, 5, 6, 7
# Why the loop returned, and its other results, in Tables.clock.
TICK, STATUS, FAILED = range(3)
NON_FINITE = -(2**31)
LAW = 15  # numbers of a law: force (3), acceleration (3), mass (3, 3)
BOND_ROW = LAW + 3 + 3  # law used, accepted force, residual, throughput, rounds


class Tables(NamedTuple):
    """All that the compiled loop reads and writes.

    nodes: (n, 16) int64, see the column names; order: (m,) int64 node indices as executed, group after group.
    groups: (g, 4) int64 first and end in `order`, first and end in `bonds`.
    terms: (k, 5) int64; gains: (k,); offsets: (o,) constants added by terms.
    delayed: (d, 3) int64 target, source, count on the board: copies made as a tick begins.
    bonds: (b, 11) int64; tolerances: (b,) [N]; bond_energy: (b, 7).
    laws, best_laws: (b, 15) for the round about to be made, and of the one that agreed best; system: (3, 7) scratch.
    capture: (c,) float64 rows of (time bits, values); capture_ns: the same memory as int64; filled: rows' ends.
    added: (signals,) offsets put on outputs by events. saved: (states,) x of bonded nodes as the tick began.
    """

    clock: np.ndarray
    nodes: np.ndarray
    order: np.ndarray
    groups: np.ndarray
    terms: np.ndarray
    gains: np.ndarray
    offsets: np.ndarray
    delayed: np.ndarray
    bonds: np.ndarray
    tolerances: np.ndarray
    bond_energy: np.ndarray
    laws: np.ndarray
    best_laws: np.ndarray
    system: np.ndarray
    inputs: np.ndarray
    states: np.ndarray
    saved: np.ndarray
    board: np.ndarray
    added: np.ndarray
    capture: np.ndarray
    capture_ns: np.ndarray
    filled: np.ndarray
