"""Binds the linear filter as printed to the contract."""

from math import atan2, log, sqrt

from components.compiled import kernel
from components.contract import Component
from components.estimator import line, straight
from components.estimator.layout import outputs_of
from components.estimator.linear import (
    BAR,
    GIVEN,
    INTERVAL,
    NODE,
    OFF_BY,
    THERE,
    WRONG_INTERVAL,
    X,
    Z,
    begin,
    gather,
    mark,
    model_of,
    write_estimate,
    write_fit,
    write_tension,
)
from components.estimator.published import model
from components.estimator.roots import log_density, multiply
from components.matrices import table

LARGEST = 1e9  # of a tension, and of its deviation [N]: levers go through zero
FLOWN = 1e12
FLOWN_OFF, INDEFINITE, UNSURE = 2, 3, 4


@kernel
def bend(w, i):
    """Joint i's angle by the markers, the first against north, and whether they are there."""
    a, b = i * NODE, i * NODE + NODE
    sound = w[a + THERE] > 0.0 and w[b + THERE] > 0.0
    x, z, dx, dz = 1.0, 0.0, w[b + X] - w[a + X], w[b + Z] - w[a + Z]
    if i > 0:
        sound = sound and w[a - NODE + THERE] > 0.0
        x, z = w[a + X] - w[a - NODE + X], w[a + Z] - w[a - NODE + Z]
    return atan2(x * dz - z * dx, x * dx + z * dz), sound


@kernel
def measure(m, p, w, state, P, y):
    """(31)-(33) with (26), one joint's angle after the other, which is the same as at once: R is diagonal. A status."""
    n, N = m.n, m.N
    out, R, nis, density, count = outputs_of(n).innovation, p[len(p) - 3], 0.0, 0.0, 0
    for i in range(n):
        y[out + i] = 0.0
        angle, sound = bend(w, i)
        if not sound:
            continue
        k = 2 * i
        innovation, variance = angle - state[k], P[k, k] + R
        if not variance > 0.0:
            return INDEFINITE
        y[out + count] = innovation / sqrt(variance)
        nis += y[out + count] * y[out + count]
        density += log_density(y[out + count], log(variance / R), 0.5 * log(R))
        count += 1
        row = w[NODE * (n + 1) : NODE * (n + 1) + N]
        for j in range(N):
            row[j] = P[k, j]
        for a in range(N):
            gain = P[a, k] / variance
            state[a] += gain * innovation
            for b in range(N):
                P[a, b] -= gain * row[b]
    write_fit(n, y, count, nis, density)
    return 0


@kernel
def root_of(P, root):
    """Write a lower root of P; what is not positive counts as zero."""
    N = P.shape[0]
    for i in range(N):
        for j in range(N):
            root[i, j] = 0.0
        for j in range(i + 1):
            total = P[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            if i == j:
                root[i, i] = sqrt(max(total, 0.0))
            elif root[j, j] > 0.0:
                root[i, j] = total / root[j, j]


@kernel
def lever(m, l, state, i):
    """l s_i of (13)-(16): theta_i+1 + 2 theta_i+2 + ..., times l."""
    total = 0.0
    for j in range(i + 1, m.n):
        total += (j - i) * state[2 * j]
    return l * total


@kernel
def pull(m, l, state, root):
    """Mean tension by the forces at all joints but the last, as figure 15 has it, and its deviation.

    Each is the force over l s_i: so do the first forces that are printed follow from F = 0.5 N and the first angles, to
    all their digits. What (13)-(16) put beside it, the weight, is left out. Where a lever is none, as of a straight
    line or of one bar, nothing tells of it.
    """
    n, F, told = m.n, 0.0, m.n > 1
    for i in range(n - 1):
        s = lever(m, l, state, i)
        told = told and s != 0.0
        F += state[2 * n + i] / (s if s != 0.0 else 1e-300) / (n - 1)
    square = 0.0
    for c in range(m.N):
        total = 0.0
        for i in range(n - 1):
            s = lever(m, l, state, i)
            part, turn = 0.0, 0.0
            for j in range(i + 1, n):
                turn += (j - i) * root[2 * j, c]
            if s != 0.0:
                part = (root[2 * n + i, c] - state[2 * n + i] / s * l * turn) / s
            total += part / (n - 1)
        square += total * total
    return min(max(F, -LARGEST), LARGEST), (min(sqrt(square), LARGEST) if told else LARGEST)


@kernel
def move(phi, P, scratch):
    """Turn P into Phi P Phi'; scratch: (N, N)."""
    N = P.shape[0]
    multiply(phi, P, scratch)
    for i in range(N):
        for j in range(N):
            total = 0.0
            for k in range(N):
                total += scratch[i, k] * phi[j, k]
            P[i, j] = total


@kernel
def read(p, u, x, y, w):
    """Use a frame and write all outputs; a status."""
    m = model_of(p)
    n, N = m.n, m.N
    state, P = x[:N], table(x, N, N, N)
    gather(p, u, w)
    mark(p, w, y)
    status = measure(m, p, w, state, P, y)
    if status:
        return status
    root = table(w, 6 * N, N, N)
    root_of(P, root)
    write_estimate(p, m, state, root, N, w, y)
    tension, spread = pull(m, p[BAR], state, root)
    write_tension(n, y, tension, spread)
    return 0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the first frame, and the forces of a first tension."""
    m = model_of(p)
    n, N = m.n, m.N
    if abs(dt_ns * 1e-9 - p[INTERVAL]) > OFF_BY * p[INTERVAL]:
        return WRONG_INTERVAL
    state, P = x[:N], table(x, N, N, N)
    gather(p, u, w)
    begin(p, m, p[GIVEN] > 0.0, w, NODE * (n + 1), state)
    for i in range(n):
        state[2 * n + i] = p[len(p) - 1] * lever(m, p[BAR], state, i)
    for i in range(N):
        for j in range(N):
            P[i, j] = 0.0
        P[i, i] = p[len(p) - 2]
    return read(p, u, x, y, w)


def step(t_ns, dt_ns, p, u, x, y, w):
    """(29), and (30) as it stands or with Phi P Phi' in it; then the frame at the step's end."""
    m = model_of(p)
    N, phi, state, fresh = m.N, m.phi, x[: m.N], w[: m.N]
    P = table(x, N, N, N)
    if p[len(p) - 4] > 0.0:
        move(phi, P, table(w, 6 * N, N, N))
    for i in range(N):
        fresh[i] = 0.0
        for j in range(N):
            fresh[i] += phi[i, j] * state[j]
    for i in range(N):
        state[i] = fresh[i]
        for j in range(N):
            P[i, j] += m.noise[i, j]
    for i in range(N):
        if not abs(state[i]) < FLOWN:
            return UNSURE if p[len(p) - 4] > 0.0 else FLOWN_OFF
    return read(p, u, x, y, w)


COMPONENT = Component(
    name="estimator.published",
    parameters=model.Published,
    inputs=line.inputs,
    outputs=straight.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    status_text={
        WRONG_INTERVAL: "the period is not `interval`, for which the filter was made: make them equal",
        FLOWN_OFF: "the estimate flew off, as (30) makes it do as printed: set moves_covariance to true",
        INDEFINITE: "a variance came out negative, as (33) loses digits where angle_variance is tiny beside the "
        "estimate's: raise it, or lower start_variance or force_variance",
        UNSURE: "the estimate flew off: lower start_tension, start_variance or force_variance",
    },
    terms=model.terms,
    assumptions="As printed, for comparison: rates of the joints for those of the bars (9), modal angles measured as "
    "if they were the joints' (26), no damping, R without what markers share; no Phi about P (30) if so asked.",
)
