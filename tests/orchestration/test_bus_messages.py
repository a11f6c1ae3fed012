"""Messages under fuzz: what is not whole, not sealed by the other, or of another run is told from what is.

Authority: the format as written in messages.py, read here a second time.
"""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.bus.identity import SEAL_BYTES, Identity, Seal
from pipeline.bus.messages import HEADER_BYTES, Message, MessageError, pack, unpack

UINT32 = st.integers(0, 2**32 - 1)
MESSAGES = st.builds(
    Message,
    kind=st.integers(0, 255),
    run=st.integers(0, 2**64 - 1),
    incarnation=UINT32,
    section=UINT32,
    sequence=st.integers(0, 2**64 - 1),
    t_ns=st.integers(-(2**63), 2**63 - 1),
    flags=st.integers(0, 255),
    status=st.integers(-(2**63), 2**63 - 1),
    failed=st.integers(-(2**31), 2**31 - 1),
    ignored=st.integers(0, 65535),
    numbers=st.binary(max_size=10).map(lambda b: 8 * b),
    text=st.binary(max_size=40),
)
ANNOUNCED = struct.Struct("<II")  # numbers and bytes of text, at the end of the header


@given(MESSAGES)
def test_whole_messages_survive(message):
    back = unpack(pack(message))
    assert back._replace(numbers=bytes(back.numbers)) == message


@given(st.binary(max_size=300))
def test_garbage(data):
    """Read, if at all, as what it announces."""
    try:
        message = unpack(data)
    except MessageError:
        return
    assert pack(message) == data


@given(MESSAGES, st.data())
def test_cut_lengthened_and_mangled(message, draw):
    data = pack(message)
    with pytest.raises(MessageError):
        unpack(data[: draw.draw(st.integers(0, len(data) - 1))])
    with pytest.raises(MessageError):
        unpack(data + draw.draw(st.binary(min_size=1, max_size=20)))
    at, flip = draw.draw(st.integers(0, len(data) - 1)), draw.draw(st.integers(1, 255))
    mangled = data[:at] + bytes([data[at] ^ flip]) + data[at + 1 :]
    numbers, text = ANNOUNCED.unpack_from(mangled, HEADER_BYTES - ANNOUNCED.size)
    is_whole = mangled[:4] == data[:4] and HEADER_BYTES + 8 * numbers + text == len(mangled)
    try:
        assert pack(unpack(mangled)) == mangled
        assert is_whole
    except MessageError:
        assert not is_whole


def pair() -> tuple[Seal, Seal]:
    conductor, host = Identity(), Identity()
    return conductor.seal_with(host.name), host.seal_with(conductor.name)


@given(st.binary(max_size=200), st.data())
def test_seal(data, draw):
    """Opens for the other as it was; not after any change, not for its sender, not for a third."""
    conductor, host = pair()
    sealed = conductor.sealed(data)
    assert host.opened(sealed) == data
    assert len(sealed) == len(data) + SEAL_BYTES
    at, flip = draw.draw(st.integers(0, len(sealed) - 1)), draw.draw(st.integers(1, 255))
    assert host.opened(sealed[:at] + bytes([sealed[at] ^ flip]) + sealed[at + 1 :]) is None
    assert host.opened(sealed[: draw.draw(st.integers(0, len(sealed) - 1))]) is None
    assert host.opened(sealed + b"\0") is None
    assert conductor.opened(sealed) is None
    assert pair()[1].opened(sealed) is None


@pytest.mark.parametrize("name", ["", "0123456789abcdef", "00" * 32, "not hexadecimal", "ff" * 33])
def test_name_that_is_no_key(name):
    """Talks to nobody, not even by an all-zero shared secret."""
    ours = Identity().seal_with(name)
    assert ours.opened(Seal(bytes(32), name, "").sealed(b"x")) is None


def test_identity_of_a_secret():
    """It is the same to a third one."""
    one, third = Identity(), Identity()
    again = Identity(one.secret)
    assert again.name == one.name
    assert again.seal_with(third.name).opened(third.seal_with(one.name).sealed(b"x")) == b"x"
