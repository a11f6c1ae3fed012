"""Binds the cable to the contract."""

from math import isfinite

from components.compiled import kernel
from components.contract import Component, LineEnd
from components.tether.cable import model, seabed
from components.tether.cable.breaking import overloaded
from components.tether.cable.dynamics import scheme
from components.tether.cable.ends import give_cross, give_force, give_law
from components.tether.cable.line import BONDED, FREE, SCRATCH, TC, Q, present, store, unpack
from components.tether.cable.start import start
from components.tether.cable.stepping import Account, at_fraction, bonded, march, remember, try_on
from components.tether.cable.terms import terms
from components.tether.cable.validity import MEASURES, measure
from components.tether.cable.winch import assemble

LAW = 15  # numbers of a law
ACCOUNT = 7 + MEASURES  # numbers between the forces and the laws, the first of them `converged`
NOT_FINITE, NO_EQUILIBRIUM, CUT_AT_REST, BREAKS_AT_REST = 1, 2, 3, 4


@kernel
def observe(line, w, y, account):
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
    k += 6
    y[k] = 1.0 if account.converged else 0.0
    y[k + 1], y[k + 2], y[k + 3], y[k + 4] = account.residual, account.iterations, account.sub_steps, account.error
    y[k + 5], y[k + 6] = account.cut + 1, line.length * line.scale
    measure(line, w, account, y, k + 7)
    return k + ACCOUNT


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
def respond(line, trial, x, w, h, y, k):
    """Write the laws about the motion just accepted, then those of a trial step; k: where the first one stands in y.

    trial: the line as it will be at the end of the trial step. The accepted forces stand against the anchors from which
    friction held the line over the step; the trial begins with those that it left, in the state x.
    """
    s = scheme(0.0, h)
    if line.anchors:
        seabed.put_back(line, w)
    give_laws(line, w, s, y, k + LAW)
    if line.end_a == BONDED and line.end_b == BONDED:
        give_cross(line, w, s.c_q, y, k + 4 * LAW)
    if line.anchors:
        seabed.recall(line, x, w)
    part = try_on(trial, w, h)
    if not part.converged:
        y[k - ACCOUNT] = 0.0
        for measure in (k - MEASURES, k - MEASURES + 1):
            y[measure] = max(y[measure], part.residual / part.allowed)
    give_laws(trial, w, s, y, k)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Hang the line in its static equilibrium between the ends' positions, moving as they do."""
    line = unpack(p, t_ns * 1e-9)
    h = dt_ns * 1e-9
    if line.event_cut > 0:
        return CUT_AT_REST
    residual, settled = start(line, x, u, w, h)
    if not settled:
        return NO_EQUILIBRIUM
    if overloaded(line, w) >= 0:
        return BREAKS_AT_REST
    store(line.n, w, x, 0)
    if line.anchors:
        seabed.keep(line, w, x)
        seabed.set_aside(line, w)
    account = Account(0, 0.0, residual, True, 0.0, 0.0, 0, 0.0, 0.0, 0, -1, 1.0, 0.0, 0.0)
    remember(line, account, x)
    k = observe(line, w, y, account)
    if bonded(line):
        respond(line, line, x, w, h, y, k)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Advance the line to the ends' new motions; on a bond, then try the next step for the law."""
    h = dt_ns * 1e-9
    account = march(p, t_ns * 1e-9, x, u, w, h)
    if not isfinite(account.residual):
        return NOT_FINITE
    line = present(p, t_ns * 1e-9, account.scale, account.payout, account.payout_change, account.cut)
    store(line.n, w, x, 0)
    if line.anchors:
        seabed.keep(line, w, x)
    remember(line, account, x)
    k = observe(line, w, y, account)
    if bonded(line):
        respond(line, at_fraction(p, line, x, u, h, 1.0, account.cut), x, w, h, y, k)
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
        NO_EQUILIBRIUM: "no static equilibrium found between the ends: check length and ends; with bending_stiffness "
        "and a seabed also axial_stiffness: beyond 1e5 times the weight, or none, it may be too much",
        CUT_AT_REST: "a line that is cut has no shape at rest to start from: leave `cut` to an event",
        BREAKS_AT_REST: "the line breaks at rest: its tension exceeds breaking_load",
    },
    lines={
        "end_a": _end("a"),
        "end_b": _end("b"),
    },
    cross={("end_a", "end_b"): "accepted_ab"},
    terms=terms,
    validity="validity.range",
    assumptions=(
        "No torsion, small axial strain, level sea bed; long-crested linear waves, in which the whole line is under "
        "water; segments short against the line's radius of curvature and the wave lengths of its motion."
    ),
)
