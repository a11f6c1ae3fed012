"""Philox against its authors' known answers; the numbers made of it against their distributions."""

import numba
import numpy as np
import pytest
from scipy import stats

from components.random import normal, philox, uniform

# Salmon et al. 2011, Random123 distribution, examples/kat_vectors, lines "philox4x32 10": counter, key, answer.
KNOWN_ANSWERS = """
00000000 00000000 00000000 00000000 00000000 00000000 6627e8d5 e169c58d bc57ac4c 9b00dbd8
ffffffff ffffffff ffffffff ffffffff ffffffff ffffffff 408f276d 41c83b0e a20bc7c6 6d5451fd
243f6a88 85a308d3 13198a2e 03707344 a4093822 299f31d0 d16cfe09 94fdcceb 5001e420 24126ea1
"""


@numba.njit
def draws(draw, high, low, stream, n):
    """2 n numbers: (n, 2)."""
    out = np.empty((n, 2))
    for i in range(n):
        out[i, 0], out[i, 1] = draw(high, low, stream, i)
    return out


@pytest.mark.parametrize("line", KNOWN_ANSWERS.strip().splitlines())
def test_known_answers(line):
    words = [int(word, 16) for word in line.split()]
    assert [int(word) for word in philox(*map(np.uint64, words[:6]))] == words[6:]


def test_seed_stream_and_counter_arrive_where_the_known_answers_have_them():
    # The second half of the third vector's counter is taken: stream 0x13198a2e is c2; c3 is always 0 here.
    key, stream, counter = (0x299F31D0, 0xA4093822), 0x13198A2E, (0x85A308D3 << 32) | 0x243F6A88
    counter &= (1 << 63) - 1
    c = [counter & 0xFFFFFFFF, counter >> 32, stream, 0, key[1], key[0]]
    a, b, _, _ = (int(word) for word in philox(*map(np.uint64, c)))
    expected = ((((a >> 6) << 26) | (b >> 6)) + 0.5) / 2**52
    assert uniform(float(key[0]), float(key[1]), stream, counter)[0] == expected


def test_uniform_is_uniform_and_open():
    # Kolmogorov-Smirnov; the numbers never change, so that the level only says how unlucky a good generator may be.
    numbers = draws(uniform, 1.0, 2.0, 0, 100_000).ravel()
    assert 0.0 < numbers.min() < numbers.max() < 1.0
    assert stats.kstest(numbers, "uniform").pvalue > 1e-3


def test_normal_is_normal_and_its_pair_independent():
    pairs = draws(normal, 3.0, 4.0, 1, 100_000)
    assert stats.kstest(pairs.ravel(), "norm").pvalue > 1e-3
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 4.0 / np.sqrt(len(pairs))  # four standard deviations


@pytest.mark.parametrize("other", [(8.0, 7.0, 0), (7.0, 9.0, 0), (7.0, 8.0, 1)])
def test_other_seeds_and_streams_are_independent(other):
    numbers = draws(normal, 7.0, 8.0, 0, 10_000)[:, 0], draws(normal, *other, 10_000)[:, 0]
    assert abs(np.corrcoef(numbers)[0, 1]) < 4.0 / np.sqrt(len(numbers[0]))  # four standard deviations
