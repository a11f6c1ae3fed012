"""Who sends a message: a process's name on the bus is its public key, and what two keys share seals what they say.

X25519 (RFC 7748) and keyed BLAKE2b (RFC 7693). It keeps anybody else on the bus from speaking for a host or the
conductor, not from offering itself as a host or from listening: that is for TLS and access control.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets

from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey

SEAL_BYTES = 16


class Seal:
    """Seals what one of a pair says to the other; each direction has a key of its own."""

    def __init__(self, shared: bytes, own: str, other: str):
        """shared: (32,) bytes; own, other: the two names."""
        self._sending, self._receiving = (
            hashlib.blake2b(name.encode(), key=shared, digest_size=32).digest() for name in (own, other)
        )

    def sealed(self, data: bytes) -> bytes:
        """The data with a seal at its end."""
        return data + hashlib.blake2b(data, key=self._sending, digest_size=SEAL_BYTES).digest()

    def opened(self, data: bytes) -> bytes | None:
        """The data without its seal; None where that is not the other's."""
        inside, seal = data[:-SEAL_BYTES], data[-SEAL_BYTES:]
        expected = hashlib.blake2b(inside, key=self._receiving, digest_size=SEAL_BYTES).digest()
        return inside if hmac.compare_digest(seal, expected) else None


class Identity:
    """A process on the bus. name: its public key; secret: what another process needs to be it; both in hexadecimal."""

    def __init__(self, secret: str = ""):
        """A new one, or the one of a secret."""
        given = bytes.fromhex(secret)
        self._key = X25519PrivateKey.from_private_bytes(given) if given else X25519PrivateKey.generate()
        self.secret = self._key.private_bytes_raw().hex()
        self.name = self._key.public_key().public_bytes_raw().hex()

    def seal_with(self, other: str) -> Seal:
        """What seals messages between the two; with a name that is no key, nothing that comes will open."""
        try:
            shared = self._key.exchange(X25519PublicKey.from_public_bytes(bytes.fromhex(other)))
        except ValueError:
            shared = secrets.token_bytes(32)
        return Seal(shared, self.name, other)
