"""A measurement of true values: bias, noise, wild points, freezes, drop-outs and delay, in this order.

An instrument's numbers: channels m, delay [samples], mean times between and of drop-outs, of freezes [s], share of wild
points, whether it is dropped, whether frozen; then for each channel noise and bias (standard deviations), the bias's
time constant [s], the size of wild points, an offset, and whether it is an angle that wraps. Its state: samples taken,
whether lost, whether frozen, biases (m), last values (m), and a ring of delay + 1 samples, each with its validity.
"""

from math import exp, inf, isfinite, sqrt

from components.bursts import probability_lost
from components.compiled import kernel
from components.kinematics import wrapped
from components.random import normal, uniform

CHANNELS, DELAY, AVAILABLE, LOST_TIME, LIVE, FREEZE_TIME, WILD_SHARE, DROPPED, FROZEN, FIRST = range(10)
NOISE, BIAS, BIAS_TIME, WILD, OFFSET, WRAPS, CHANNEL = range(7)
TAKEN, IS_LOST, IS_FROZEN, BIASES = range(4)


@kernel
def streams(q):
    """How many streams of random numbers an instrument draws from."""
    return 2 * int(q[CHANNELS]) + 2


@kernel
def drift(k, bias, h, fresh):
    """A channel's bias after h [s], exactly a Gauss-Markov process of first order; h infinite: as it is at any time."""
    kept = exp(-h / k[BIAS_TIME]) if h < inf else 0.0
    return kept * bias + k[BIAS] * sqrt(1.0 - kept * kept) * fresh


@kernel
def sample(q, truth, h, high, low, stream, x):
    """Draw a sample of the true values into the state's last values; whether it is valid."""
    m, count = int(q[CHANNELS]), int(x[TAKEN])
    fate, freeze = uniform(high, low, stream + 2 * m, count)
    wild, _ = uniform(high, low, stream + 2 * m + 1, count)
    x[IS_LOST] = 1.0 if fate < probability_lost(x[IS_LOST], q[AVAILABLE], q[LOST_TIME], h) else 0.0
    was_frozen = x[IS_FROZEN] if h < inf else 0.0
    chance = probability_lost(was_frozen, q[LIVE], q[FREEZE_TIME], h) if h < inf else 0.0
    x[IS_FROZEN] = 1.0 if freeze < chance else 0.0
    is_known = True
    for i in range(m):
        is_known = is_known and isfinite(truth[i])
    holds = (x[IS_FROZEN] > 0.0 or q[FROZEN] > 0.0) and h < inf
    for i in range(m):
        k = q[FIRST + CHANNEL * i : FIRST + CHANNEL * (i + 1)]
        noise, fresh = normal(high, low, stream + 2 * i, count)
        side, _ = uniform(high, low, stream + 2 * i + 1, count)
        x[BIASES + i] = drift(k, x[BIASES + i], h, fresh)
        if holds or not is_known:
            continue
        value = truth[i] + x[BIASES + i] + k[NOISE] * noise + k[OFFSET]
        if wild < q[WILD_SHARE]:
            value += k[WILD] if side < 0.5 else -k[WILD]
        x[BIASES + m + i] = wrapped(value) if k[WRAPS] > 0.0 else value
    return is_known and x[IS_LOST] == 0.0 and q[DROPPED] == 0.0


@kernel
def measure(q, truth, h, high, low, stream, x, y):
    """Sample the true values (m) and write what comes out now to y (m), zeros where nothing valid does; 1 if valid.

    h: time since the last sample [s], infinite for the first; high, low: the seed; stream: of the random numbers, the
    first of streams(q); x: the state.
    """
    m, slots = int(q[CHANNELS]), int(q[DELAY]) + 1
    ring = BIASES + 2 * m
    if h == inf:
        for i in range(ring + (m + 1) * slots):
            x[i] = 0.0
    else:
        x[TAKEN] += 1.0
    at = ring + (m + 1) * (int(x[TAKEN]) % slots)
    x[at] = 1.0 if sample(q, truth, h, high, low, stream, x) else 0.0
    for i in range(m):
        x[at + 1 + i] = x[BIASES + m + i]
    at = ring + (m + 1) * ((int(x[TAKEN]) + 1) % slots)
    for i in range(m):
        y[i] = x[at + 1 + i] if x[at] > 0.0 else 0.0
    return x[at]
