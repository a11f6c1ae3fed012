"""One step of the line between its ends' motions at two instants, in sub-steps, and its trial step."""

from math import inf
from typing import NamedTuple

from components.compiled import kernel
from components.tether.cable import balance, flow, seabed, winch
from components.tether.cable.breaking import again, overloaded
from components.tether.cable.dynamics import align, finish, newton, predict, scheme
from components.tether.cable.ends import place
from components.tether.cable.error_control import end_error, position_error, smooth_error
from components.tether.cable.line import (
    ACC,
    BONDED,
    CUT,
    LEAD,
    LEVEL,
    RATE,
    SCALE,
    SCRATCH,
    STATE,
    A,
    T,
    V,
    first_unknown,
    last_unknown,
    load,
    present,
    saved,
    store,
    tail,
    unpack,
)
from components.tether.cable.snap import impact
from components.tether.cable.start import accelerate

# The shortest sub-step is the longest one halved so often.
HALVINGS = 10
# The error of a sub-step grows by 2^3 when it is doubled; it is doubled where it leaves twice that.
ROOM = 1.0 / 16.0


class Attempt(NamedTuple):
    """How a sub-step went."""

    iterations: int  # Newton's
    residual: float  # largest imbalance [N]
    allowed: float  # what was to be put up with [N]
    converged: bool
    error: float  # estimated, of a position [m]
    snap: float  # largest tension by an impact that the sub-step does not resolve [N]
    lead: float  # of the algorithmic accelerations over the true ones [s]


class Account(NamedTuple):
    """What a step leaves to report and, from `lead` on, to remember beside the nodes; of all its sub-steps."""

    iterations: int  # Newton's, of all sub-steps tried
    excess: float  # largest imbalance over what was to be put up with
    residual: float  # largest imbalance [N]
    converged: bool
    error: float
    snap: float
    sub_steps: int
    again: float  # of a broken line: how far it was beyond breaking once more
    lead: float
    level: int
    cut: int  # index of the segment that is cut, -1: none
    scale: float
    payout: float
    payout_change: float


class Sums(NamedTuple):
    """What the accepted sub-steps of a period come to; iterations of those tried in vain too."""

    iterations: int
    excess: float
    residual: float
    error: float
    snap: float
    sub_steps: int


class Division(NamedTuple):
    """How the period may be divided."""

    shortest: int  # sub-steps in it if all were the shortest
    halvings: int
    fixed: bool  # whether the user or a bond fixes the sub-step
    accuracy: float  # position error of a sub-step that is put up with [m]


@kernel
def bonded(line):
    """Whether an end exchanges a force law with a body."""
    return line.end_a == BONDED or line.end_b == BONDED


@kernel
def slack(line, w):
    """Whether a segment of a line that takes no compression hangs loose."""
    if line.tension_only:
        for i in range(line.n):
            if w[i * SCRATCH + T] <= 0.0 and i != line.cut:
                return True
    return False


@kernel
def calm(line, x, w, h):
    """Leave to the free nodes the mean acceleration of the step of h [s] from x to w.

    After a snap the acceleration that short steps resolve would, held over a long one, throw the nodes away.
    """
    for i in range(first_unknown(line), last_unknown(line) + 1):
        for c in range(3):
            mean = (w[i * SCRATCH + V + c] - x[i * STATE + V + c]) / h
            w[i * SCRATCH + ACC + c] = mean
            w[i * SCRATCH + A + c] = mean


@kernel
def cut_at(line, w, segment):
    """Cut the segment: its tension is gone at once, and the accelerations with it.

    On a bond the step does not shrink to resolve how the ends spring apart; held over all of it that would throw them.
    """
    w[segment * SCRATCH + T] = 0.0
    if not bonded(line):
        accelerate(line, w)


@kernel
def at_fraction(p, line, x, u, h, fraction, cut):
    """The line at a fraction of the period's h [s]: as long as the winch has it; once it is cut as long as it was."""
    if line.winch == 0 or cut >= 0:
        return present(p, line.t, line.scale, 0.0, 0.0, cut)
    k = tail(line)
    scale, payout, change = winch.wound(line, x[k + SCALE], x[k + RATE], u[line.rate], h, fraction)
    return present(p, line.t, scale, payout, change, cut)


@kernel
def begin(line, x, w, h, cut):
    """Bring the nodes from x to w, cut where an event cuts the line now; returns the lead of their accelerations."""
    load(line.n, x, 0, w)
    if line.anchors:
        seabed.recall(line, x, w)
    if line.water:
        flow.sample(line, w, line.t - h, True)
    k = tail(line)
    if cut >= 0 and x[k + CUT] == 0.0:
        cut_at(line, w, cut)
        return 0.0
    return x[k + LEAD]


@kernel
def attempt(line, s, x, u, w, old, start, h, at, to, end, accuracy, lead):
    """Take the nodes in w over the sub-step from at/end to to/end of the period; old[start:]: where it began."""
    taut = not slack(line, w)
    if taut:
        align(line, s, lead, w)
    predict(s, w, line.n, taut)
    place(line, x, u, w, h, to, end)
    if line.water:
        flow.sample(line, w, line.t - h * ((end - to) / end), True)
    count, residual, allowed, converged = newton(line, s, w)
    finish(line, s, w)
    error = position_error(line, s, w, old, start)
    if converged and error > accuracy:
        error = smooth_error(line, s, w, old, start)
        winch.assemble(line, w, s.c_m, s.c_c)
    error = max(error, end_error(line, s, w, old, start))
    return Attempt(count, residual, allowed, converged, error, impact(line, s, w, old, start), s.lead)


@kernel
def division(line):
    """The user's sub-steps, or the period and its halves; one on a bond, whose ends follow the body's scheme."""
    fixed, halvings = line.sub_steps > 0 or bonded(line), 0 if bonded(line) else HALVINGS
    return Division(max(line.sub_steps, 1) << halvings, halvings, fixed, inf if fixed else line.accuracy)


@kernel
def set_aside(line, w):
    """Keep the nodes as a sub-step finds them."""
    store(line.n, w, w, saved(line))
    if line.anchors:
        seabed.set_aside(line, w)


@kernel
def put_back(line, w):
    """Return the nodes to what was set aside."""
    load(line.n, w, saved(line), w)
    if line.anchors:
        seabed.put_back(line, w)


@kernel
def tried(sums, part):
    """The sums with the iterations of a sub-step that is taken again."""
    iterations = sums.iterations + part.iterations
    return Sums(iterations, sums.excess, sums.residual, sums.error, sums.snap, sums.sub_steps)


@kernel
def counted(sums, part):
    """The sums with an accepted sub-step."""
    excess, residual = sums.excess, sums.residual
    if not part.residual <= residual:  # so that one that is not finite is kept
        residual = part.residual
    if not part.residual <= excess * part.allowed:
        excess = part.residual / part.allowed
    return Sums(
        sums.iterations + part.iterations, excess, residual, max(sums.error, part.error), max(sums.snap, part.snap),
        sums.sub_steps + 1,
    )  # fmt: skip


@kernel
def march(p, t, x, u, w, h):
    """Advance the line over the step of h [s] from the state x to the end motions in u; the new nodes are in w.

    Sub-steps are the period (over `sub_steps`, where the user fixes that) over powers of two, so that they end where
    it does. One whose iteration fails or, where the line chooses them itself, whose position error exceeds the
    accuracy, is halved; so is one in which the line breaks, down to the shortest, at whose end it is cut. After a
    failure rho_inf = 0 to the period's end, which an impact does not excite. If the shortest fails too, one step over
    the whole period stands as the iteration left it.
    """
    line = unpack(p, t)
    if line.winch != 0:
        line = present(p, t, x[tail(line) + SCALE], 0.0, 0.0, -1)
    if line.water:
        flow.hear(line, u, w)
    d = division(line)
    level = 0 if d.fixed else int(x[tail(line) + LEVEL])
    cut = int(x[tail(line) + CUT]) - 1 if x[tail(line) + CUT] > 0.0 else line.event_cut - 1
    lead = begin(at_fraction(p, line, x, u, h, 0.0, cut), x, w, h, cut)
    at, rough, beyond, sums = 0, False, 0.0, Sums(0, 0.0, 0.0, 0.0, 0.0, 0)
    while at < d.shortest:
        to = at + (1 << (d.halvings - level))
        line = at_fraction(p, line, x, u, h, to / d.shortest, cut)
        set_aside(line, w)
        s = scheme(0.0 if rough or slack(line, w) else line.rho_inf, h * ((to - at) / d.shortest))
        part = attempt(line, s, x, u, w, w, saved(line), h, at, to, d.shortest, d.accuracy, lead)
        broken = overloaded(line, w) if cut < 0 else -1
        if level < d.halvings and (not part.converged or part.error > d.accuracy or broken >= 0):
            rough = rough or not part.converged
            level += 1
            sums = tried(sums, part)
            put_back(line, w)
            continue
        if not part.converged and d.halvings > 0:
            lead = begin(line, x, w, h, cut)
            to, s = d.shortest, scheme(0.0, h)
            line = at_fraction(p, line, x, u, h, 1.0, cut)
            part = attempt(line, s, x, u, w, x, 0, h, 0, to, to, inf, lead)
        at, lead, sums = to, part.lead, counted(sums, part)
        if cut >= 0:
            beyond = max(beyond, again(line, w))
        if broken >= 0:
            cut = broken
            line = at_fraction(p, line, x, u, h, at / d.shortest, cut)
            cut_at(line, w, cut)
            balance.assemble(line, w, s.c_m, s.c_c)
        easy = d.fixed or part.error < ROOM * d.accuracy
        if level > 0 and easy and not rough and at % (2 << (d.halvings - level)) == 0:
            level -= 1
    if rough or sums.excess > 1.0:
        calm(line, x, w, h)
    return Account(
        sums.iterations, sums.excess, sums.residual, sums.excess <= 1.0, sums.error, sums.snap, sums.sub_steps, beyond,
        lead, level, cut, line.scale, line.payout, line.payout_change,
    )  # fmt: skip


@kernel
def remember(line, account, x):
    """Write to x what the next step needs beside the nodes."""
    k = tail(line)
    x[k + LEAD], x[k + LEVEL], x[k + CUT] = account.lead, account.level, account.cut + 1
    if line.winch != 0:
        x[k + SCALE], x[k + RATE] = account.scale, account.payout


@kernel
def try_on(line, w, h):
    """From the accepted nodes in w, step h [s] further with the ends' accelerations held; w becomes the trial."""
    s = scheme(0.0, h)
    predict(s, w, line.n, False)
    if line.water:
        flow.sample(line, w, line.t + h, True)
    return newton(line, s, w)
