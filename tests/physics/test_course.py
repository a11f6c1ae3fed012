"""The course of a vessel: uniform outside its rows, through its rows, and with rates that belong to its path."""

import numpy as np
import pytest
from pydantic import ValidationError

from components.compiled import functions
from components.motion.course.component import COMPONENT
from components.motion.course.model import Course

ROWS = ((2.0, 0.0, 0.0, 0.0), (4.0, 2.0, 0.0, 0.0), (6.0, 3.5, 1.0, 0.0), (8.0, 4.0, 3.0, 0.5))
ORIGIN = (10.0, -5.0, 1.0)
_, step = functions(COMPONENT)


def motion(seconds, rows=ROWS):
    """Position, velocity, acceleration, each (len(seconds), 3); whatever is not written would be NaN."""
    p = COMPONENT.pack(Course(origin=ORIGIN, table=rows))
    y = np.full((len(seconds), 9), np.nan)
    for row, t in zip(y, seconds, strict=True):
        assert step(round(t * 1e9), 10**7, p, np.empty(0), np.empty(0), row, np.empty(0)) == 0
    return y[:, :3], y[:, 3:6], y[:, 6:]


def test_it_goes_through_its_rows_and_on_at_their_ends():
    table = np.array(ROWS)
    position, velocity, _ = motion(table[:, 0])
    assert position == pytest.approx(table[:, 1:] + ORIGIN, abs=1e-12)
    assert velocity[[0, -1]] == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.25, 1.0, 0.25]]), abs=1e-12)
    before, v, a = motion([0.0, 1.0])
    assert before == pytest.approx(np.array([[8.0, -5.0, 1.0], [9.0, -5.0, 1.0]]), abs=1e-12)
    assert not a.any()
    after, v, a = motion([9.0, 12.0])
    assert after[1] - after[0] == pytest.approx([0.75, 3.0, 0.75], abs=1e-12)
    assert v[0] == pytest.approx([0.25, 1.0, 0.25], abs=1e-12)
    assert not a.any()


def test_rates_belong_to_the_path():
    # Central differences over 1 ms of polynomials of degree five: 1e-6; smooth across all joints.
    t, h = np.linspace(1.0, 9.0, 81), 1e-3
    (x1, v1, _), (_, v, a), (x2, v2, _) = motion(t - h), motion(t), motion(t + h)
    assert (x2 - x1) / (2 * h) == pytest.approx(v, abs=1e-5)
    assert (v2 - v1) / (2 * h) == pytest.approx(a, abs=1e-3)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (ROWS[:1], "table has 1 rows: a course needs at least 2"),
        ((ROWS[0], (4.0, 1.0)), "table.1 is .*: expected four finite numbers"),
        ((ROWS[1], ROWS[0]), "table.1: time 2 s: expected times that increase"),
    ],
)
def test_what_does_not_fit_is_refused(rows, words):
    with pytest.raises(ValidationError, match=words):
        Course(table=rows)
