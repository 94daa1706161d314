"""Datagrams of the UDP path: header, AES-128-GCM, replay window (proto/README.md#the-udp-path)."""

from __future__ import annotations

import dataclasses
import enum
import struct

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

HEADER = struct.Struct(">2sBBIQ")
TAG_SIZE = 16
LARGEST = 1200
_MAGIC, _VERSION = b"hp", 1
_WINDOW = 1024
_MOST_PACKETS = 2**32


class Type(enum.IntEnum):
    PROXY = 1
    STATE = 2
    PATH_CHALLENGE = 3
    PATH_RESPONSE = 4
    CLOSE = 5


_DOWN = frozenset({Type.STATE, Type.PATH_CHALLENGE, Type.PATH_RESPONSE, Type.CLOSE})


class ReplayWindow:
    """Which of the newest 1024 packet numbers have arrived."""

    def __init__(self) -> None:
        self.newest = 0
        self._seen = 0  # bit i: newest - i

    def fresh(self, number: int) -> bool:
        if number > self.newest:
            return True
        behind = self.newest - number
        return behind < _WINDOW and not self._seen >> behind & 1

    def commit(self, number: int) -> None:
        if number > self.newest:
            self._seen = (self._seen << (number - self.newest) | 1) & ((1 << _WINDOW) - 1)
            self.newest = number
        else:
            self._seen |= 1 << (self.newest - number)


@dataclasses.dataclass(slots=True)
class Keys:
    """The keys of both directions, and the counts of the datagrams under them. Not thread-safe."""

    path_id: int
    up: AESGCM
    up_salt: bytes
    down: AESGCM
    down_salt: bytes
    sent: int = 0
    received: int = 0  # datagrams whose tag was right
    window: ReplayWindow = dataclasses.field(default_factory=ReplayWindow)

    @classmethod
    def of(cls, path_id: int, up_key: bytes, up_salt: bytes, down_key: bytes,
           down_salt: bytes) -> Keys:
        return cls(path_id, AESGCM(up_key), up_salt, AESGCM(down_key), down_salt)

    def seal(self, kind: Type, payload: bytes) -> bytes | None:
        """The next datagram up; None once the keys are worn out."""
        if self.sent >= _MOST_PACKETS:
            return None
        self.sent += 1
        header = HEADER.pack(_MAGIC, _VERSION, kind, self.path_id, self.sent)
        return header + self.up.encrypt(self.up_salt + header[8:], payload, header)

    def open(self, datagram: bytes) -> tuple[Type, bytes] | None:
        """Opens a datagram from the server. None: drop it. Checks in the protocol's order."""
        reading = read_header(datagram)
        if reading is None or reading[1] != self.path_id:
            return None
        kind, _, number = reading
        if not self.window.fresh(number):
            return None
        header = datagram[:HEADER.size]
        try:
            payload = self.down.decrypt(self.down_salt + header[8:], datagram[HEADER.size:], header)
        except InvalidTag:
            return None
        self.window.commit(number)
        self.received += 1
        return kind, payload


def read_header(datagram: bytes) -> tuple[Type, int, int] | None:
    """Type, path id and packet number of a datagram from the server; None: it is not one."""
    if not HEADER.size + TAG_SIZE <= len(datagram) <= LARGEST:
        return None
    magic, version, kind, path_id, number = HEADER.unpack_from(datagram)
    if (magic, version) != (_MAGIC, _VERSION) or kind not in _DOWN:
        return None
    if not 0 < number <= _MOST_PACKETS:
        return None
    return Type(kind), path_id, number
