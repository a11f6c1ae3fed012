"""Requests kept for a host that is started again, in memory or in a file. Authority: a plain list."""

from __future__ import annotations

import random

import pytest

from pipeline import recovery
from pipeline.errors import HostError
from pipeline.recovery import Tape


@pytest.mark.parametrize("limit", [1, 100, 1000, 1 << 20])
def test_kept_in_order_wherever_they_are(limit, monkeypatch):
    monkeypatch.setattr(recovery, "TAPE_BYTES", limit)
    dice, tape = random.Random(7), Tape()
    for _ in range(3):
        kept = [dice.randbytes(dice.randrange(60)) for _ in range(50)]
        for i, data in enumerate(kept):
            tape.append(data)
            if i % 7 == 0:
                assert tape[dice.randrange(i + 1)] in kept
        assert len(tape) == len(kept)
        assert [tape[i] for i in range(len(kept))] == kept
        tape.clear()
        assert len(tape) == 0


def test_full_disk(monkeypatch):
    """The run can stop with its log whole. Authority: /dev/full."""
    monkeypatch.setattr(recovery, "TAPE_BYTES", 10)
    monkeypatch.setattr(recovery, "TemporaryFile", lambda: open("/dev/full", "w+b"))  # noqa: SIM115 - clear() closes
    tape = Tape()
    with pytest.raises(HostError, match=r"cannot keep what a host .* No space left on device; TMPDIR names another"):
        tape.append(bytes(100))
    tape.clear()
