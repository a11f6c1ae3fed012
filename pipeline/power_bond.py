"""Power bonds in the compiled loop: the body's law against the line's force, laws for another round, energies.

A bond's law is F(a) = force - mass (a - acceleration), 15 numbers; see the contract's law_ports.
"""

import numpy as np

from components.compiled import kernel
from pipeline.loop_tables import (
    ACCELERANCE,
    ACCEPTED,
    BODY,
    BODY_LAW,
    BOND_CAPTURE,
    BOND_ROW,
    CROSS,
    LAST_POSITION,
    LAW,
    MOTION,
    OTHER,
    OTHER_FIRST,
    REPEATS,
    RESIDUAL,
    ROUNDS,
    THROUGHPUT,
    UNCONVERGED,
)


@kernel
def law_force(k, b, axis):
    """Force [N] along an axis that bond b's law gives at the body's present acceleration."""
    law, a = k.bonds[b, BODY_LAW], k.bonds[b, MOTION] + 6
    force = k.inputs[law + axis]
    for c in range(3):
        force -= k.inputs[law + 6 + 3 * axis + c] * (k.board[a + c] - k.inputs[law + 3 + c])
    return force


@kernel
def mismatch(k, b):
    """Norm [N] of the line's accepted force minus what the body reckoned with."""
    square = 0.0
    for axis in range(3):
        difference = k.board[k.bonds[b, ACCEPTED] + axis] - law_force(k, b, axis)
        square += difference * difference
    return np.sqrt(square)


@kernel
def solve(m):
    """Gauss-Jordan with partial pivoting on m (3, 7): its last four columns become solutions for its first three."""
    for j in range(3):
        pivot = j
        for i in range(j + 1, 3):
            if abs(m[i, j]) > abs(m[pivot, j]):
                pivot = i
        for c in range(7):
            m[j, c], m[pivot, c] = m[pivot, c], m[j, c]
        scale = 1.0 / m[j, j]
        for c in range(7):
            m[j, c] *= scale
        for i in range(3):
            factor = m[i, j]
            if i != j:
                for c in range(7):
                    m[i, c] -= factor * m[j, c]


@kernel
def let_yield(k, b):
    """Let bond b's law in k.laws, which has the line's other end held, yield with the body there.

    Here o is the other end, r what its body's balance lacked of the accepted force, Y that body's accelerance and
    G = -dF/da the line's. Its balance da_o = Y (r - G_ob da - G_oo da_o) gives da_o = (1 + Y G_oo)^-1 Y (r - G_ob da),
    and the force on this body is F - G_bb da - G_bo da_o. Both bodies' balances, each solved with its own such law,
    are Newton's step for the two bodies and the line together.
    """
    m, board, law, o = k.system, k.board, k.laws[b], k.bonds[b, OTHER]
    accepted, accelerance, cross = k.bonds[o, ACCEPTED], k.bonds[b, ACCELERANCE], k.bonds[b, CROSS]
    row, column = (3, 1) if k.bonds[b, OTHER_FIRST] else (1, 3)  # G_ob[n, j] is board[cross + row * n + column * j]
    for i in range(3):
        for j in range(7):
            m[i, j] = 1.0 if i == j else 0.0
        for n in range(3):
            y = board[accelerance + 3 * i + n]
            m[i, 3] += y * (board[accepted + n] - law_force(k, o, n))
            for j in range(3):
                m[i, j] += y * board[accepted + 6 + 3 * n + j]
                m[i, 4 + j] += y * board[cross + row * n + column * j]
    solve(m)
    for i in range(3):
        for n in range(3):
            g = board[cross + row * n + column * i]
            law[i] -= g * m[n, 3]
            for j in range(i, 3):
                law[6 + 3 * i + j] -= g * m[n, 4 + j]
    law[9], law[12], law[13] = law[7], law[8], law[11]


@kernel
def relinearise(k, first, end):
    """Make the next round's laws: about the motion that the lines accepted last."""
    for b in range(first, end):
        for c in range(LAW):
            k.laws[b, c] = k.board[k.bonds[b, ACCEPTED] + c]
        if k.bonds[b, OTHER] >= 0:
            let_yield(k, b)


@kernel
def keep_laws(k, first, end):
    """Note the laws of the round just made as the best so far."""
    for b in range(first, end):
        for c in range(LAW):
            k.best_laws[b, c] = k.inputs[k.bonds[b, BODY_LAW] + c]


@kernel
def recall_laws(k, first, end):
    """Make the best round's laws the next round's."""
    for b in range(first, end):
        for c in range(LAW):
            k.laws[b, c] = k.best_laws[b, c]


@kernel
def give_laws(k, i, first, end):
    """Give body i the laws made for this round in place of those it has wired."""
    for b in range(first, end):
        if k.bonds[b, BODY] == i:
            for c in range(LAW):
                k.inputs[k.bonds[b, BODY_LAW] + c] = k.laws[b, c]


@kernel
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


@kernel
def judge(k, first, end, rounds):
    """Largest excess [N] of a mismatch over its tolerance, and whether a bond with one may have another round."""
    worst, again = -np.inf, False
    for b in range(first, end):
        excess = mismatch(k, b) - k.tolerances[b]
        worst = max(worst, excess)
        again = again or (excess > 0.0 and rounds < k.bonds[b, ROUNDS])
    return worst, again
