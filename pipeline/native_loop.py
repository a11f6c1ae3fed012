"""The conductor's loop compiled: gathers inputs, calls step functions by address, checks and captures outputs.

Everything is an index into five flat arrays (see memory.py): p, u, x, w of all components and the board of signals.
The loop holds no GIL and returns at a given tick, or as soon as a component stops the run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from components import compiled

# Columns of Tables.nodes. Addresses are machine addresses, the rest are indices and counts.
(STEP, P, U, X, Y, W, DT_NS, PERIOD, BOARD, N_Y, STATE, N_X, FIRST_TERM, END_TERM, CAPTURE, OFFSET_ON) = range(16)
# Columns of Tables.terms.
TARGET, SOURCE, COUNT, OFFSET, ASSIGNS = range(5)
# Columns of Tables.bonds.
LINE, BODY, MOTION, ACCEPTED, BODY_LAW, ROUNDS, BOND_CAPTURE = range(7)
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
    bonds: (b, 7) int64; tolerances: (b,) [N]; bond_energy: (b, 7).
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
    inputs: np.ndarray
    states: np.ndarray
    saved: np.ndarray
    board: np.ndarray
    added: np.ndarray
    capture: np.ndarray
    capture_ns: np.ndarray
    filled: np.ndarray


@intrinsic
def call(typingctx, address, t_ns, dt_ns, p, u, x, y, w):
    """Call the contract's C function at an address."""
    signature = types.int64(*[types.int64] * 8)

    def generate(context, builder, signature, args):
        word, vector = ir.IntType(64), ir.DoubleType().as_pointer()
        function = ir.FunctionType(word, [word, word, *[vector] * 5])
        pointers = [builder.inttoptr(a, vector) for a in args[3:]]
        return builder.call(builder.inttoptr(args[0], function.as_pointer()), [args[1], args[2], *pointers])

    return signature, generate


@njit(inline="always", **compiled.OPTIONS)
def gather(k, i):
    """Fill node i's inputs: copies, sums and linear functions of signals, in the order they were written."""
    for j in range(k.nodes[i, FIRST_TERM], k.nodes[i, END_TERM]):
        target, source, count = k.terms[j, TARGET], k.terms[j, SOURCE], k.terms[j, COUNT]
        offset, assigns, gain = k.terms[j, OFFSET], k.terms[j, ASSIGNS], k.gains[j]
        if assigns and gain == 1.0 and offset < 0:
            for c in range(count):
                k.inputs[target + c] = k.board[source + c]
            continue
        for c in range(count):
            value = 0.0
            if gain != 0.0:
                value = gain * k.board[source + c]
            if offset >= 0:
                value += k.offsets[offset + c]
            if not assigns:
                value += k.inputs[target + c]
            k.inputs[target + c] = value


@njit(inline="always", **compiled.OPTIONS)
def step_node(k, i, t_ns):
    """Step node i with the inputs gathered; 0, its status, or NON_FINITE."""
    n = k.nodes
    status = call(n[i, STEP], t_ns, n[i, DT_NS], n[i, P], n[i, U], n[i, X], n[i, Y], n[i, W])
    first, end = n[i, BOARD], n[i, BOARD] + n[i, N_Y]
    if n[i, OFFSET_ON]:
        for c in range(first, end):
            k.board[c] += k.added[c]
    zero = 0.0
    for c in range(first, end):
        zero += k.board[c] - k.board[c]
    if status == 0 and zero != 0.0:
        return NON_FINITE
    return status


@njit(inline="always", **compiled.OPTIONS)
def capture(k, i, t_ns):
    """Append node i's outputs to its captured rows."""
    row = k.filled[i]
    k.capture_ns[row] = t_ns
    first, n_y = k.nodes[i, BOARD], k.nodes[i, N_Y]
    for c in range(n_y):
        k.capture[row + 1 + c] = k.board[first + c]
    k.filled[i] = row + 1 + n_y


@njit(inline="always", **compiled.OPTIONS)
def law_force(k, b, axis):
    """Force [N] along an axis that bond b's law gives at the body's present acceleration."""
    law, a = k.bonds[b, BODY_LAW], k.bonds[b, MOTION] + 6
    force = k.inputs[law + axis]
    for c in range(3):
        force -= k.inputs[law + 6 + 3 * axis + c] * (k.board[a + c] - k.inputs[law + 3 + c])
    return force


@njit(inline="always", **compiled.OPTIONS)
def mismatch(k, b):
    """Norm [N] of the line's accepted force minus what the body reckoned with."""
    square = 0.0
    for axis in range(3):
        difference = k.board[k.bonds[b, ACCEPTED] + axis] - law_force(k, b, axis)
        square += difference * difference
    return np.sqrt(square)


@njit(inline="always", **compiled.OPTIONS)
def relinearise(k, i, first, end):
    """Give body i, for a repeated step, the laws about the motion that its lines accepted last."""
    for b in range(first, end):
        if k.bonds[b, BODY] == i:
            for c in range(LAW):
                k.inputs[k.bonds[b, BODY_LAW] + c] = k.board[k.bonds[b, ACCEPTED] + c]


@njit(inline="always", **compiled.OPTIONS)
def account(k, b, t_ns, rounds, worst):
    """Sum up bond b's energies and capture its row."""
    e = k.bond_energy[b]
    row = k.bonds[b, BOND_CAPTURE]
    at = k.filled[row]
    k.capture_ns[at] = t_ns
    for c in range(LAW):
        k.capture[at + 1 + c] = k.inputs[k.bonds[b, BODY_LAW] + c]
    for axis in range(3):
        position = k.board[k.bonds[b, MOTION] + axis]
        force = k.board[k.bonds[b, ACCEPTED] + axis]
        moved = position - e[LAST_POSITION + axis]
        e[RESIDUAL] += (force - law_force(k, b, axis)) * moved
        e[THROUGHPUT] += abs(force * moved)
        e[LAST_POSITION + axis] = position
        k.capture[at + 1 + LAW + axis] = force
    e[REPEATS] += rounds - 1
    if worst > k.tolerances[b]:
        e[UNCONVERGED] += 1.0
    k.capture[at + 1 + LAW + 3] = e[RESIDUAL]
    k.capture[at + 1 + LAW + 4] = e[THROUGHPUT]
    k.capture[at + 1 + LAW + 5] = float(rounds)
    k.filled[row] = at + 1 + BOND_ROW


@njit(inline="always", **compiled.OPTIONS)
def copy_states(k, group, source, target):
    """Copy x of the group's nodes from one array of all states to another."""
    for m in range(k.groups[group, 0], k.groups[group, 1]):
        n = k.nodes[k.order[m]]
        for c in range(n[STATE], n[STATE] + n[N_X]):
            target[c] = source[c]


@njit(inline="always", **compiled.OPTIONS)
def step_bonded(k, group, t_ns):
    """Step a group that power bonds tie, repeating it with re-linearised laws until forces agree; (node, status)."""
    first_bond, end_bond = k.groups[group, 2], k.groups[group, 3]
    copy_states(k, group, k.states, k.saved)
    rounds = 0
    while True:
        rounds += 1
        for m in range(k.groups[group, 0], k.groups[group, 1]):
            i = k.order[m]
            gather(k, i)
            if rounds > 1:
                relinearise(k, i, first_bond, end_bond)
            status = step_node(k, i, t_ns)
            if status != 0:
                return i, status
        again = False
        for b in range(first_bond, end_bond):
            again = again or (mismatch(k, b) > k.tolerances[b] and rounds < k.bonds[b, ROUNDS])
        if not again:
            break
        copy_states(k, group, k.saved, k.states)
    for b in range(first_bond, end_bond):
        account(k, b, t_ns, rounds, mismatch(k, b))
    return 0, 0


@njit(inline="always", **compiled.OPTIONS)
def step_group(k, group, t_ns):
    """Step a group that is due and capture its outputs; (node, status)."""
    first, end = k.groups[group, 0], k.groups[group, 1]
    i, status = k.order[first], 0
    if end - first == 1:
        gather(k, i)
        status = step_node(k, i, t_ns)
    else:
        i, status = step_bonded(k, group, t_ns)
    if status == 0:
        for m in range(first, end):
            capture(k, k.order[m], t_ns)
    return i, status


@njit(nogil=True, cache=True, **compiled.OPTIONS)
def advance(k, until, start_ns, base_ns):
    """Advance the world tick by tick to `until`; returns early, with k.clock saying why, when a component stops it."""
    while k.clock[TICK] < until:
        tick = k.clock[TICK] + 1
        t_ns = start_ns + tick * base_ns
        for d in range(len(k.delayed)):
            target, source = k.delayed[d, 0], k.delayed[d, 1]
            for c in range(k.delayed[d, 2]):
                k.board[target + c] = k.board[source + c]
        for group in range(len(k.groups)):
            period = k.nodes[k.order[k.groups[group, 0]], PERIOD]
            if period == 1 or tick % period == 0:
                i, status = step_group(k, group, t_ns)
                if status != 0:
                    k.clock[STATUS], k.clock[FAILED] = status, i
                    return
        k.clock[TICK] = tick


@njit(nogil=True, cache=True, **compiled.OPTIONS)
def initialise(k, inits, count, t_ns):
    """Gather and call the first `count` nodes' inits in the order of execution; k.clock says whether one failed."""
    for m in range(count):
        i = k.order[m]
        gather(k, i)
        n = k.nodes[i]
        step = n[STEP]
        n[STEP] = inits[i]
        status = step_node(k, i, t_ns)
        n[STEP] = step
        if status != 0:
            k.clock[STATUS], k.clock[FAILED] = status, i
            return
        capture(k, i, t_ns)
    for b in range(len(k.bonds)):
        for axis in range(3):
            k.bond_energy[b, LAST_POSITION + axis] = k.board[k.bonds[b, MOTION] + axis]


def prepare(k, inits):
    """Compile both functions, or load them, without stepping anything."""
    initialise(k, inits, 0, 0)
    advance(k, k.clock[TICK], 0, 1)
    compiled.mark_cached(__file__)
