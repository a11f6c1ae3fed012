"""Binds propellers and thrusters to the contract."""

from math import cos, isfinite, sin

from components.compiled import kernel
from components.contract import HEADER, Component
from components.thrusters.propulsion import model
from components.thrusters.propulsion.following import follow, shortest
from components.thrusters.propulsion.propeller import (
    AZIMUTH_KIND,
    AZIMUTH_RATE,
    AZIMUTH_TIME,
    FASTEST,
    HEADING,
    KIND,
    NUMBERS,
    RUDDER,
    SPEED_RATE,
    SPEED_TIME,
    STRAIGHT,
    X,
    Y,
    power_of,
    speed_for,
    thrust_of,
)

COUNT, MEETS_WATER, FAILURES = range(3)
STOPS, KEEPS, RUNS_AWAY, STUCK = range(1, 5)


@kernel
def wanted_azimuth(k, azimuth, command):
    """The azimuth [rad] to turn to: the command's shortest way, within a rudder's angle."""
    if k[KIND] == STRAIGHT or not isfinite(command):
        return azimuth
    to = shortest(azimuth, command)
    if k[KIND] == AZIMUTH_KIND:
        return to
    off = shortest(0.0, to - k[HEADING])
    return k[HEADING] + min(max(off, -k[RUDDER]), k[RUDDER])


@kernel
def wanted_speed(k, failure, speed, command):
    """The shaft speed [rad/s] to run up to; a command that is no number leaves it as it is."""
    if failure == STOPS:
        return 0.0
    if failure == RUNS_AWAY:
        return k[FASTEST] if speed >= 0.0 else -k[FASTEST]
    if failure == KEEPS or not isfinite(command):
        return speed
    return speed_for(k, command)


@kernel
def write_forces(q, u, x, y):
    """Write thrusts, azimuths, speeds, powers, their sum, and which obey."""
    n = int(q[COUNT])
    total = 4 * n
    y[total] = y[total + 1] = y[total + 2] = 0.0
    for i in range(n):
        k = q[FAILURES + n + NUMBERS * i : FAILURES + n + NUMBERS * (i + 1)]
        speed, azimuth = x[i], x[n + i]
        c, s = cos(azimuth), sin(azimuth)
        advance = 0.0
        if q[MEETS_WATER] > 0.0:
            ahead, across, turn = u[2 * n], u[2 * n + 1], u[2 * n + 2]
            advance = c * (ahead - turn * k[Y]) + s * (across + turn * k[X])
        thrust = thrust_of(k, speed, advance)
        y[i], y[n + i], y[2 * n + i], y[3 * n + i] = thrust, azimuth, speed, power_of(k, speed, advance)
        y[total] += c * thrust
        y[total + 1] += s * thrust
        y[total + 2] += (k[X] * s - k[Y] * c) * thrust
        y[total + 3 + i] = 1.0 if q[FAILURES + i] == 0.0 else 0.0


def init(t_ns, dt_ns, p, u, x, y, w):
    """At rest, turned as asked."""
    q = p[HEADER:]
    n = int(q[COUNT])
    for i in range(n):
        k = q[FAILURES + n + NUMBERS * i : FAILURES + n + NUMBERS * (i + 1)]
        x[i], x[n + i] = 0.0, k[HEADING]
        x[n + i] = wanted_azimuth(k, x[n + i], u[n + i])
    write_forces(q, u, x, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Follow the commands over the step."""
    q, h = p[HEADER:], dt_ns * 1e-9
    n = int(q[COUNT])
    for i in range(n):
        k = q[FAILURES + n + NUMBERS * i : FAILURES + n + NUMBERS * (i + 1)]
        failure = q[FAILURES + i]
        x[i] = follow(x[i], wanted_speed(k, failure, x[i], u[i]), k[SPEED_TIME], k[SPEED_RATE], h)
        if failure != STOPS and failure != STUCK:
            x[n + i] = follow(x[n + i], wanted_azimuth(k, x[n + i], u[n + i]), k[AZIMUTH_TIME], k[AZIMUTH_RATE], h)
    write_forces(q, u, x, y)
    return 0


COMPONENT = Component(
    name="thrusters.propulsion",
    parameters=model.Propulsion,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Propellers of fixed pitch deep in undisturbed water: no ventilation, no wake of others, no loss of a "
    "tunnel by the vessel's speed; thrust falls in a line with the advance number; a rudder turns the force and takes "
    "nothing of it.",
)
