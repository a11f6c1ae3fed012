"""The ends' velocities over a horizon that bring a line nearest to a shape: what one step of the law does not see.

The plan is the ends' velocities at knots, linear between. It is bettered by Gauss and Newton's method with Levenberg's
damping, slopes by differences, and moved on with each step (receding horizon); where the law's own way over it is
better, planning begins from that. A plan that hurries may come to rest farther from the shape than the law does later:
of the bettered plan, the last one moved on and the law, that is followed which ends nearest if the law goes on after
it (a rollout). So in the end it is not farther than the law alone, as far as the model holds.
"""

from math import sqrt

from components.compiled import kernel
from components.controller.shape.law import steer
from components.controller.shape.layout import (
    EDGE,
    EFFORT,
    HORIZON,
    KNOTS,
    LENGTH,
    MAX_SPEED,
    NORMAL,
    PASSES,
    STEPS,
    TANGENTIAL,
    TARGET,
)
from components.controller.shape.rates import factor, solve, turning
from components.kinematics import wrapped

LAST = 20.0  # weight of the last shape beside 1 for the mean of all
LOOK, EVEN = 4, 1e-6  # horizons over which the law goes on after a plan; ends that differ by less count as even
FINE = 1e-5  # m/s, by which a knot is moved to see what it does
TIMID, BOLD, FIRST, MOST = 4.0, 0.3, 1e-3, 1e6  # factors of the damping, its start, and where no step helps


@kernel
def planned(q, plan, share, velocity):
    """Write the velocities (4) at a share of the horizon, no end faster than the largest speed."""
    knots = int(q[KNOTS])
    place = min(max(share, 0.0), 1.0) * (knots - 1)
    i = min(int(place), knots - 2)
    part = place - i
    for j in range(EDGE):
        velocity[j] = (1.0 - part) * plan[EDGE * i + j] + part * plan[EDGE * (i + 1) + j]
    for end in range(2):
        speed = sqrt(velocity[2 * end] * velocity[2 * end] + velocity[2 * end + 1] * velocity[2 * end + 1])
        if speed > q[MAX_SPEED]:
            velocity[2 * end] *= q[MAX_SPEED] / speed
            velocity[2 * end + 1] *= q[MAX_SPEED] / speed


@kernel
def roll(q, start, plan, way, theta, wanted, drag, sides, rates, system, velocity):
    """Follow the plan from the angles `start` and write the weighted errors on the way (steps, n); their square sum.

    Steps of Euler's method: the plan is for the next moves, not for the decimals of the last.
    """
    n, steps = len(theta), int(q[STEPS])
    h, total = q[HORIZON] / steps, 0.0
    for i in range(n):
        theta[i] = start[i]
    for k in range(steps):
        planned(q, plan, (k + 0.5) / steps, velocity)
        turning(theta, q[LENGTH] / n, q[NORMAL], q[TANGENTIAL], drag, sides, rates)
        weight = sqrt(1.0 / steps + (LAST if k == steps - 1 else 0.0))
        for i in range(n):
            turn = 0.0
            for j in range(EDGE):
                turn += rates[i, j] * velocity[j]
            theta[i] += h * turn
            error = weight * wrapped(q[TARGET + i] - theta[i])
            way[k * n + i] = error
            total += error * error
    return total


@kernel
def follow(q, horizons, theta, wanted, drag, sides, rates, system, velocity):
    """Square sum of the errors that the law comes to from the angles theta, which are changed."""
    h = q[HORIZON] / int(q[STEPS])
    for _ in range(horizons * int(q[STEPS])):
        steer(q, theta, wanted, drag, sides, rates, system, velocity)
        for i in range(len(theta)):
            for j in range(EDGE):
                theta[i] += h * rates[i, j] * velocity[j]
    total = 0.0
    for i in range(len(theta)):
        error = wrapped(q[TARGET + i] - theta[i])
        total += error * error
    return total


@kernel
def effort(q, plan):
    """What the velocities themselves count."""
    total = 0.0
    for i in range(len(plan)):
        total += q[EFFORT] * plan[i] * plan[i] / len(plan)
    return total


@kernel
def copy_law(q, start, plan, theta, wanted, drag, sides, rates, system, velocity):
    """Write the velocities at the knots that the law would give from the angles `start`."""
    n, steps, knots = len(theta), int(q[STEPS]), int(q[KNOTS])
    h, knot = q[HORIZON] / steps, 0
    for i in range(n):
        theta[i] = start[i]
    for k in range(steps + 1):
        steer(q, theta, wanted, drag, sides, rates, system, velocity)
        while knot < knots and knot * steps <= k * (knots - 1):
            for j in range(EDGE):
                plan[EDGE * knot + j] = velocity[j]
            knot += 1
        for i in range(n):
            for j in range(EDGE):
                theta[i] += h * rates[i, j] * velocity[j]


@kernel
def move_on(q, plan, trial, h):
    """Shift the plan by h [s]; what comes after its end is its end."""
    knots = int(q[KNOTS])
    for knot in range(knots):
        planned(q, plan, knot / (knots - 1) + h / q[HORIZON], trial[EDGE * knot : EDGE * (knot + 1)])
    for i in range(len(plan)):
        plan[i] = trial[i]


@kernel
def improve(q, start, plan, damping, ways, normal, step, theta, wanted, drag, sides, rates, system, velocity):
    """Better the plan by one pass; the damping to go on with. ways: (knots * 4 + 2, steps * n) of scratch."""
    many = len(plan)
    cost = roll(q, start, plan, ways[many], theta, wanted, drag, sides, rates, system, velocity) + effort(q, plan)
    for i in range(many):
        kept = plan[i]
        plan[i] = kept + FINE
        roll(q, start, plan, ways[i], theta, wanted, drag, sides, rates, system, velocity)
        plan[i] = kept
        for k in range(ways.shape[1]):
            ways[i, k] = (ways[i, k] - ways[many, k]) / FINE
    while damping < MOST:
        for i in range(many):
            step[i, 0] = -q[EFFORT] / many * plan[i]
            for k in range(ways.shape[1]):
                step[i, 0] -= ways[i, k] * ways[many, k]
            for j in range(i + 1):
                total = 0.0
                for k in range(ways.shape[1]):
                    total += ways[i, k] * ways[j, k]
                normal[i, j] = normal[j, i] = total
            normal[i, i] += q[EFFORT] / many + damping
        factor(normal)
        solve(normal, step)
        for i in range(many):
            plan[i] += step[i, 0]
        # The last row is the base's errors, which a failed trial must not lose.
        found = roll(q, start, plan, ways[many + 1], theta, wanted, drag, sides, rates, system, velocity)
        if found + effort(q, plan) < cost:
            return max(damping * BOLD, 1e-9)
        for i in range(many):
            plan[i] -= step[i, 0]
        damping *= TIMID
    return FIRST


@kernel
def replan(
    q, start, plan, damping, h, ways, normal, step, trial, kept, theta, wanted, drag, sides, rates, system, velocity
):
    """The plan for the next step: moved on by h [s], begun anew where the law is better, then bettered.

    Returns its damping, and whether the law ends nearer to the shape than any plan.
    trial: the numbers of step (4 * knots, 1) as a vector; kept: as many of scratch.
    """
    many = len(plan)
    move_on(q, plan, trial, h)
    cost = roll(q, start, plan, ways[many], theta, wanted, drag, sides, rates, system, velocity) + effort(q, plan)
    before = follow(q, LOOK, theta, wanted, drag, sides, rates, system, velocity)
    for i in range(many):
        kept[i] = plan[i]
    copy_law(q, start, trial, theta, wanted, drag, sides, rates, system, velocity)
    other = roll(q, start, trial, ways[many], theta, wanted, drag, sides, rates, system, velocity) + effort(q, trial)
    if other < cost:
        for i in range(many):
            plan[i] = trial[i]
    for _ in range(int(q[PASSES])):
        damping = improve(
            q, start, plan, damping, ways, normal, step, theta, wanted, drag, sides, rates, system, velocity
        )
    roll(q, start, plan, ways[many], theta, wanted, drag, sides, rates, system, velocity)
    after = follow(q, LOOK, theta, wanted, drag, sides, rates, system, velocity)
    for i in range(len(theta)):
        theta[i] = start[i]
    law = follow(q, LOOK + 1, theta, wanted, drag, sides, rates, system, velocity)
    if after > min(before, law) + EVEN and before <= law:
        for i in range(many):
            plan[i] = kept[i]
    return damping, min(before, after) > law + EVEN
