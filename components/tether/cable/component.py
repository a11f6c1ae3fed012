"""Binds the cable to the contract."""

from math import isfinite

from components.compiled import kernel
from components.contract import Component, LineEnd
from components.tether.cable import model, seabed
from components.tether.cable.balance import assemble
from components.tether.cable.dynamics import scheme
from components.tether.cable.ends import give_cross, give_force, give_law
from components.tether.cable.line import BONDED, FREE, SCRATCH, TC, Q, store, unpack
from components.tether.cable.stepping import bonded, march, start, try_on
from components.tether.cable.terms import terms

LAW = 15  # numbers of a law
CONVERGED = -3  # where it stands in y, counted from the laws
NOT_FINITE, NO_EQUILIBRIUM = 1, 2


@kernel
def observe(line, w, y, converged, residual, iterations):
    """Write shape, tensions, end forces and the solver's account; returns where the laws begin in y."""
    n = line.n
    k = 3 * (n + 1)
    for i in range(n + 1):
        for c in range(3):
            y[3 * i + c] = w[i * SCRATCH + Q + c]
    for i in range(n):
        y[k + i] = w[i * SCRATCH + TC]
    k += n
    give_force(w, 0, y, k)
    give_force(w, n, y, k + 3)
    for c in range(3):
        if line.end_a == FREE:
            y[k + c] = 0.0
        if line.end_b == FREE:
            y[k + 3 + c] = 0.0
    y[k + 6], y[k + 7], y[k + 8] = converged, residual, iterations
    return k + 9


@kernel
def give_laws(line, w, s, y, k):
    """Write the law of each bonded end about the motion assembled last; k: where the first one stands in y."""
    if line.end_a == BONDED:
        give_law(line, w, 0, s.c_q, y, k)
        k += 2 * LAW
    if line.end_b == BONDED:
        if line.end_a == BONDED:
            assemble(line, w, s.c_m, s.c_c)
        give_law(line, w, line.n, s.c_q, y, k)


@kernel
def respond(line, w, h, y, k):
    """Write the laws about the motion just accepted, then those of a trial step; k: where the first one stands in y."""
    s = scheme(line.rho_inf, h)
    give_laws(line, w, s, y, k + LAW)
    if line.end_a == BONDED and line.end_b == BONDED:
        give_cross(line, w, s.c_q, y, k + 4 * LAW)
    if not try_on(line, w, h):
        y[k + CONVERGED] = 0.0
    give_laws(line, w, s, y, k)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Hang the line in its static equilibrium between the ends' positions, moving as they do."""
    line = unpack(p, t_ns * 1e-9)
    h = dt_ns * 1e-9
    residual, settled = start(line, x, u, w, h)
    if not settled:
        return NO_EQUILIBRIUM
    store(line.n, w, x)
    if line.anchors:
        seabed.keep(line, w, x)
    k = observe(line, w, y, 1.0, residual, 0.0)
    if bonded(line):
        respond(line, w, h, y, k)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Advance the line to the ends' new motions; on a bond, then try the next step for the law."""
    line = unpack(p, t_ns * 1e-9)
    h = dt_ns * 1e-9
    iterations, residual, converged = march(line, x, u, w, h)
    if not isfinite(residual):
        return NOT_FINITE
    store(line.n, w, x)
    if line.anchors:
        seabed.keep(line, w, x)
    k = observe(line, w, y, 1.0 if converged else 0.0, residual, float(iterations))
    if bonded(line):
        respond(line, w, h, y, k)
    return 0


def _end(name: str) -> LineEnd:
    return LineEnd(
        motion=f"end_{name}",
        force=f"force_{name}",
        law=f"law_{name}",
        accepted=f"accepted_{name}",
        switch=f"bond_{name}",
        stiffness=model.axial_spring,
    )


COMPONENT = Component(
    name="tether.cable",
    parameters=model.Cable,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    status_text={
        NOT_FINITE: "the line's motion became non-finite: shorten the period, add sub_steps or check the ends' motion",
        NO_EQUILIBRIUM: "no static equilibrium found between the ends: check length, axial_stiffness and the ends",
    },
    lines={
        "end_a": _end("a"),
        "end_b": _end("b"),
    },
    cross={("end_a", "end_b"): "accepted_ab"},
    terms=terms,
    assumptions=(
        "No torsion, small axial strain, level sea bed; long-crested linear waves, in which the whole line is under water; "
        "segments short against the line's radius of curvature and the wave lengths of its motion."
    ),
)
