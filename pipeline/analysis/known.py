"""What of recorded numbers can be worked with: finite, of a size that occurs, one message a time; what is odd."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

LARGEST = 1e30  # beyond it squares and a figure's 32 bits overflow, and no quantity of a scene is so large
MISSING = 2.5  # times the usual interval, beyond which messages are missing between two
TAIL_S = 1.0  # of an interrupted log that one channel may be written further than another


def known(values: np.ndarray) -> np.ndarray:
    """The same numbers, NaN for those that are not finite or beyond LARGEST; a copy only where there are some."""
    with np.errstate(invalid="ignore"):
        is_known = np.abs(values) <= LARGEST
    return values if is_known.all() else np.where(is_known, values, np.nan)


def first_of_each(t_ns: np.ndarray) -> np.ndarray:
    """(k,) bool: the first message of each time, times being in order."""
    return np.concatenate([[True], np.diff(t_ns) > 0])[: len(t_ns)]


def finite(values: np.ndarray) -> np.ndarray:
    """(k,) those of any shape that are finite."""
    return values[np.isfinite(values)]


def oddities(name: str, t_ns: np.ndarray, unknown: int, end_ns: int) -> Iterator[str]:
    """What of a channel should be known before its figures are trusted, a line each.

    t_ns: (k,) of its messages as they stand in the log; unknown: messages with numbers that are not finite; end_ns:
    of the log.
    """
    if not len(t_ns):
        yield f"{name} has no message"
        return
    if unknown:
        which = f"hold numbers that are not finite or beyond {LARGEST:g}: left out"
        yield f"{name}: {unknown} of {len(t_ns)} messages {which}"
    first = first_of_each(t_ns)
    if not first.all():
        yield f"{name}: {int((~first).sum())} of {len(t_ns)} messages repeat a time: the first of each is kept"
    t = np.append(t_ns[first], end_ns) / 1e9
    if len(t) < 4:
        return
    apart = np.diff(t)
    usual = np.median(apart[:-1])
    gaps = np.flatnonzero(apart > MISSING * usual)
    gaps = gaps[(gaps < len(apart) - 1) | (apart[gaps] > TAIL_S)]
    if len(gaps):
        i = gaps[apart[gaps].argmax()]
        more = f", and {len(gaps) - 1} shorter gaps" if len(gaps) > 1 else ""
        yield f"{name}: no message between {t[i]:.6g} and {t[i + 1]:.6g} s{more}"
