"""Counter-based random numbers: Philox-4x32-10, a pure function of a 64-bit key, a stream and a counter.

Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3", SC'11, sections 3.3 and 4. A component
takes the key from p[SEED_HIGH] and p[SEED_LOW], numbers its own streams from 0 and keeps the counter in its x (or
takes it from the time), so that the same step draws the same numbers in whatever order, process or machine it runs.
"""

from math import cos, log, pi, sin, sqrt

import numpy as np

from components.compiled import kernel

_M0 = np.uint64(0xD2511F53)
_M1 = np.uint64(0xCD9E8D57)
_W0 = np.uint64(0x9E3779B9)
_W1 = np.uint64(0xBB67AE85)
_MASK = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_ROUNDS = 10
# 26 of a word's 32 bits: two words give 52 bits, and (k + 1/2) / 2^52 is then exact and never 0 or 1.
_DROP = np.uint64(6)
_KEEP = np.uint64(26)


@kernel
def philox(c0, c1, c2, c3, k0, k1):
    """Philox-4x32-10 of the counter (c0, c1, c2, c3) under the key (k0, k1): four 32-bit words, all held in uint64."""
    for _ in range(_ROUNDS):
        product0 = _M0 * c0
        product1 = _M1 * c2
        c0 = (product1 >> _HALF) ^ c1 ^ k0
        c2 = (product0 >> _HALF) ^ c3 ^ k1
        c1 = product1 & _MASK
        c3 = product0 & _MASK
        k0 = (k0 + _W0) & _MASK
        k1 = (k1 + _W1) & _MASK
    return c0, c1, c2, c3


@kernel
def words(seed_high, seed_low, stream, counter):
    """Four random 32-bit words (uint64) of a component's draw.

    seed_high, seed_low: p[SEED_HIGH], p[SEED_LOW]; stream: 0 <= int < 2^32; counter: 0 <= int < 2^63.
    """
    count = np.uint64(counter)
    return philox(
        count & _MASK, count >> _HALF, np.uint64(stream), np.uint64(0), np.uint64(seed_low), np.uint64(seed_high)
    )


@kernel
def unit(high, low):
    """A number in the open interval (0, 1) with 52 random bits, from two 32-bit words."""
    bits = ((high >> _DROP) << _KEEP) | (low >> _DROP)
    return (float(bits) + 0.5) / 4503599627370496.0  # 2^52


@kernel
def uniform(seed_high, seed_low, stream, counter):
    """Two independent numbers, uniform on the open interval (0, 1); arguments as in words()."""
    a, b, c, d = words(seed_high, seed_low, stream, counter)
    return unit(a, b), unit(c, d)


@kernel
def normal(seed_high, seed_low, stream, counter):
    """Two independent standard normal numbers; Box and Muller 1958; arguments as in words()."""
    u, v = uniform(seed_high, seed_low, stream, counter)
    r = sqrt(-2.0 * log(u))
    return r * cos(2.0 * pi * v), r * sin(2.0 * pi * v)
