"""The conductor's loop compiled: gathers inputs, calls step functions by address, checks and captures outputs.

Everything is an index into five flat arrays (see memory.py): p, u, x, w of all components and the board of signals.
The loop holds no GIL and returns at a given tick, or as soon as a component stops the run.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from components.cache import mark_cached
from components.compiled import OPTIONS, mended
from pipeline.loop_tables import (
    ASSIGNS,
    BOARD,
    COUNT,
    DT_NS,
    END_TERM,
    FAILED,
    FIRST_TERM,
    LAST_POSITION,
    MOTION,
    N_X,
    N_Y,
    NON_FINITE,
    OFFSET,
    OFFSET_ON,
    PERIOD,
    SOURCE,
    STATE,
    STATUS,
    STEP,
    TARGET,
    TICK,
    WIDTH,
    P,
    Tables,
    U,
    W,
    X,
    Y,
)
from pipeline.power_bond import account, give_laws, judge, keep_laws, mismatch, recall_laws, relinearise


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


@njit(inline="always", **OPTIONS)
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


@njit(inline="always", **OPTIONS)
def step_node(k, i, t_ns):
    """Step node i with the inputs gathered; 0, its status, or NON_FINITE."""
    n = k.nodes
    # An intrinsic is called without the typing context that its definition begins with.
    status = call(n[i, STEP], t_ns, n[i, DT_NS], n[i, P], n[i, U], n[i, X], n[i, Y], n[i, W])  # pyright: ignore[reportCallIssue]
    first, end = n[i, BOARD], n[i, BOARD] + n[i, N_Y]
    if n[i, OFFSET_ON]:
        for c in range(first, end):
            k.board[c] += k.added[c]
    is_bad = False
    for c in range(first, end):
        is_bad |= (k.board[c] - k.board[c]) != 0.0
    if status == 0 and is_bad:
        return NON_FINITE
    return status


@njit(inline="always", **OPTIONS)
def capture(k, i, t_ns):
    """Append node i's outputs to its captured rows."""
    row = k.filled[i]
    k.capture_ns[row] = t_ns
    first, width = k.nodes[i, BOARD], k.nodes[i, WIDTH]
    for c in range(width):
        k.capture[row + 1 + c] = k.board[first + c]
    k.filled[i] = row + 1 + width


@njit(inline="always", **OPTIONS)
def copy_states(k, group, source, target):
    """Copy x of the group's nodes from one array of all states to another."""
    for m in range(k.groups[group, 0], k.groups[group, 1]):
        n = k.nodes[k.order[m]]
        for c in range(n[STATE], n[STATE] + n[N_X]):
            target[c] = source[c]


@njit(inline="always", **OPTIONS)
def make_round(k, group, t_ns, rounds):
    """Step a group's nodes once, from the saved states and with k.laws if rounds were made before; (node, status)."""
    if rounds > 0:
        copy_states(k, group, k.saved, k.states)
    for m in range(k.groups[group, 0], k.groups[group, 1]):
        i = k.order[m]
        gather(k, i)
        if rounds > 0:
            give_laws(k, i, k.groups[group, 2], k.groups[group, 3])
        status = step_node(k, i, t_ns)
        if status != 0:
            return i, status
    return 0, 0


@njit(inline="always", **OPTIONS)
def step_bonded(k, group, t_ns):
    """Step a group that power bonds tie, repeating it with re-linearised laws until forces agree; (node, status).

    Where they never do, the round that came nearest is made once more.
    """
    first, end = k.groups[group, 2], k.groups[group, 3]
    copy_states(k, group, k.states, k.saved)
    rounds, least = 0, np.inf
    while True:
        i, status = make_round(k, group, t_ns, rounds)
        rounds += 1
        if status != 0:
            return i, status
        worst, again = judge(k, first, end, rounds)
        if again:
            if worst < least:
                least = worst
                keep_laws(k, first, end)
            relinearise(k, first, end)
        elif worst > 0.0 and worst > least:
            recall_laws(k, first, end)
            least = np.inf
        else:
            break
    for b in range(first, end):
        account(k, b, t_ns, rounds, mismatch(k, b))
    return 0, 0


@njit(inline="always", **OPTIONS)
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


@njit(nogil=True, cache=True, **OPTIONS)
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


def pointer_to(kind) -> Any:
    """A function of compiled code that makes an address a pointer to numbers of a kind."""

    @intrinsic
    def pointer(typingctx, address):
        def generate(context, builder, signature, args):
            return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.int64), generate

    return pointer


words_at, numbers_at = pointer_to(types.int64), pointer_to(types.float64)


@njit(nogil=True, cache=True, error_model="numpy")  # carray is refused without numba's runtime
def advance_at(h, rows, tick, until, start_ns, base_ns):
    """Advance from a tick, captured rows beginning at `rows`; the status of the component that stopped the run, or 0.

    h: the tables as `places_of` tells them: to unpack two dozen arrays takes longer than a small step.
    """
    k = Tables(
        clock=carray(words_at(h[0, 0]), h[0, 1]),
        nodes=carray(words_at(h[1, 0]), (h[1, 1], h[1, 2])),
        order=carray(words_at(h[2, 0]), h[2, 1]),
        groups=carray(words_at(h[3, 0]), (h[3, 1], h[3, 2])),
        terms=carray(words_at(h[4, 0]), (h[4, 1], h[4, 2])),
        gains=carray(numbers_at(h[5, 0]), h[5, 1]),
        offsets=carray(numbers_at(h[6, 0]), h[6, 1]),
        delayed=carray(words_at(h[7, 0]), (h[7, 1], h[7, 2])),
        bonds=carray(words_at(h[8, 0]), (h[8, 1], h[8, 2])),
        tolerances=carray(numbers_at(h[9, 0]), h[9, 1]),
        bond_energy=carray(numbers_at(h[10, 0]), (h[10, 1], h[10, 2])),
        laws=carray(numbers_at(h[11, 0]), (h[11, 1], h[11, 2])),
        best_laws=carray(numbers_at(h[12, 0]), (h[12, 1], h[12, 2])),
        system=carray(numbers_at(h[13, 0]), (h[13, 1], h[13, 2])),
        inputs=carray(numbers_at(h[14, 0]), h[14, 1]),
        states=carray(numbers_at(h[15, 0]), h[15, 1]),
        saved=carray(numbers_at(h[16, 0]), h[16, 1]),
        board=carray(numbers_at(h[17, 0]), h[17, 1]),
        added=carray(numbers_at(h[18, 0]), h[18, 1]),
        capture=carray(numbers_at(h[19, 0]), h[19, 1]),
        capture_ns=carray(words_at(h[20, 0]), h[20, 1]),
        filled=carray(words_at(h[21, 0]), h[21, 1]),
    )
    for channel in range(len(rows)):
        k.filled[channel] = rows[channel]
    k.clock[TICK], k.clock[STATUS] = tick, 0
    advance(k, until, start_ns, base_ns)
    return k.clock[STATUS]


def places_of(k):
    """(22, 3) int64: address and shape of each table, which must live as long as this is used."""
    return np.array([(table.ctypes.data, *(*table.shape, 1)[:2]) for table in k], np.int64)


@njit(nogil=True, cache=True, **OPTIONS)
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
    """Compile these functions, or load them, without stepping anything."""
    mended(lambda: initialise(k, inits, 0, 0))
    mended(lambda: advance(k, k.clock[TICK], 0, 1))
    mended(lambda: advance_at(places_of(k), k.filled[:0], k.clock[TICK], k.clock[TICK], 0, 1))
    mark_cached("native_loop")


@njit(nogil=True, cache=True, **OPTIONS)
def step_through(k, u, y, first, end, start_ns, step_ns):
    """Steps first..end-1 of node 0 alone, inputs from u (k, n_u), outputs to y (k, n_y).

    Returns the step that failed, with k.clock saying why, else end.
    """
    for s in range(first, end):
        for c in range(u.shape[1]):
            k.inputs[c] = u[s, c]
        status = step_node(k, 0, start_ns + s * step_ns)
        if status != 0:
            k.clock[STATUS], k.clock[FAILED] = status, 0
            return s
        for c in range(y.shape[1]):
            y[s, c] = k.board[c]
    return end
