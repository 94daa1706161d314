"""The client's end of a session's UDP path: a socket, a thread, the keys."""

from __future__ import annotations

import re
import socket
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

from ._channel import LARGEST, Keys, Type, read_header
from ._path import KEEP_PAYLOAD, PathMachine, PathState
from .v1 import session_pb2 as wire

_RESPONSE = struct.Struct(">8sqqQQ")
_OLD_KEYS_S = 1.0
_LONGEST_DRAIN = 256
Address = tuple[socket.AddressFamily, socket.SocketKind, int, str, Any]  # as getaddrinfo has it
_TURN_S = 0.005  # how often the path is looked at; challenges are 10 ms apart at most


class UdpCarrier:
    """Carries samples while `in_use`, and gives states to `on_state`. Calls `on_late` if the newest
    sample may be lost: when the path is given up or in doubt. Both are called on the thread of this
    object, without its lock."""

    def __init__(self, offer: wire.UdpPath, address: str, period_s: float,
                 on_state: Callable[[bytes], None], on_late: Callable[[], None]) -> None:
        """Raises OSError if the host has no address that can be reached."""
        self._on_state, self._on_late = on_state, on_late
        self._lock = threading.Lock()
        self._keys = _keys_of(offer)
        self._old: Keys | None = None
        self._old_until = float("inf")  # runs from the first datagram under the new keys
        self._machine = PathMachine(period_s, time.monotonic())
        self._closing = False
        self._addresses = addresses(offer.host or host_of(address), offer.port)
        self._turn = 0
        self._answered = False  # by the address in use, to a whole round of challenges
        self._doubt = False
        # Last, so that nothing fails after it: a socket without an owner would stay open.
        self._socket = connect(self._addresses)
        self._socket.settimeout(_TURN_S)
        self._thread = threading.Thread(target=self._serve, name="haptic udp", daemon=True)
        self._thread.start()

    @property
    def in_use(self) -> bool:
        return self._machine.state is PathState.IN_USE

    def send(self, sample: bytes) -> bool:
        """False: the stream has to carry the sample, because the path is not in use or the sample
        too large, or it should carry it too, because answers of the path are overdue."""
        with self._lock:
            if not self.in_use or len(sample) > LARGEST - 32:
                return False
            sent = self._send(Type.PROXY, sample)
            return sent and not self._doubt

    def rekey(self, offer: wire.UdpPath) -> None:
        with self._lock:
            self._old, self._old_until = self._keys, float("inf")
            self._keys = _keys_of(offer)
            self._machine.rekeyed()

    def close(self) -> None:
        with self._lock:
            self._closing = True
            self._machine.closed()
            self._send(Type.CLOSE, b"")
        self._thread.join()
        self._socket.close()

    def _send(self, kind: Type, payload: bytes, keys: Keys | None = None) -> bool:
        datagram = (keys or self._keys).seal(kind, payload)
        if datagram is None:
            return False
        try:
            self._socket.send(datagram)
        except OSError:  # nothing listens there, or the queue is full: the silence will tell
            return False
        return True

    def _serve(self) -> None:
        used = doubted = False
        while not self._closing:
            self._take(0)  # waits
            for _ in range(_LONGEST_DRAIN):  # all that waits, before any judgement about silence
                if not self._take(socket.MSG_DONTWAIT):
                    break
            now = time.monotonic()
            with self._lock:
                probing = self._machine.state is PathState.PROBING
                challenge = self._machine.step(now)
                refused = probing and self._machine.state is PathState.WAITING
                self._answered = self._answered or self.in_use
                if challenge is not None:
                    self._send(Type.PATH_CHALLENGE, challenge)
                self._doubt = self._machine.in_doubt(now)
            if refused and not self._answered:
                self._try_another()
            if not self._closing and not doubted and (used and not self.in_use or self._doubt):
                self._on_late()
            used, doubted = self.in_use, self._doubt

    def _take(self, flags: int) -> bool:
        """Takes one datagram; False if none came."""
        try:
            datagram = self._socket.recv(LARGEST + 1, flags)
        except OSError:
            return False
        payload = self._receive(datagram, time.monotonic())
        if payload is not None:
            self._on_state(payload)
        return True

    def _try_another(self) -> None:
        """A connected UDP socket does not tell whether anything listens there: "localhost" is ::1
        and 127.0.0.1, and a server may listen at one of them only. An address that answered once
        stays."""
        if len(self._addresses) < 2:
            return
        self._turn += 1
        try:
            made = connect(self._addresses, self._turn)
        except OSError:
            return
        made.settimeout(_TURN_S)
        with self._lock:
            made, self._socket = self._socket, made
        made.close()

    def _receive(self, datagram: bytes, now: float) -> bytes | None:
        """Acts on a datagram; returns its payload if it is a state."""
        with self._lock:
            keys = self._keys_for(datagram, now)
            opened = keys.open(datagram) if keys is not None else None
            if keys is None or opened is None:
                return None
            if keys is self._keys and self._old is not None and self._old_until == float("inf"):
                self._old_until = now + _OLD_KEYS_S
            kind, payload = opened
            if kind is Type.STATE:
                return payload
            if kind is Type.CLOSE:
                self._machine.closed()
            elif len(payload) >= KEEP_PAYLOAD:
                if kind is Type.PATH_CHALLENGE:
                    self._answer(payload, keys)
                else:
                    token, came, left, packets, newest = _RESPONSE.unpack_from(payload)
                    self._machine.responded(token, (left - came) * 1e-9, packets, newest, now)
        return None

    def _keys_for(self, datagram: bytes, now: float) -> Keys | None:
        if self._old is not None and now > self._old_until:
            self._old = None
        reading = read_header(datagram)
        both = (self._keys, self._old)
        return next((k for k in both if reading and k and k.path_id == reading[1]), None)

    def _answer(self, challenge: bytes, keys: Keys) -> None:
        came = time.monotonic_ns()
        response = _RESPONSE.pack(challenge[:8], came, time.monotonic_ns(), keys.received,
                                  keys.window.newest)
        self._send(Type.PATH_RESPONSE, response.ljust(len(challenge), b"\0"), keys)


def open_udp(opened: wire.SessionOpened, address: str, period_s: float,
             on_state: Callable[[bytes], None], on_late: Callable[[], None]) -> UdpCarrier | None:
    """None if the server offers none or cannot be reached: the stream carries all then."""
    try:
        return UdpCarrier(opened.udp, address, period_s, on_state, on_late) \
            if opened.HasField("udp") else None
    except OSError:
        return None


def _keys_of(offer: wire.UdpPath) -> Keys:
    return Keys.of(offer.path_id, offer.up_key, offer.up_salt, offer.down_key, offer.down_salt)


def host_of(address: str) -> str:
    """The host of the stream's address; loopback if that is a UNIX socket."""
    if address.startswith("unix:"):
        return "127.0.0.1"
    # "dns://192.0.2.53/robot.example:PORT" names a resolver of gRPC and its server.
    host = re.sub("^(dns|ipv4|ipv6):(//[^/]*/)?", "", address).rpartition(":")[0]
    return host.strip("[]")


def addresses(host: str, port: int) -> list[Address]:
    """Addresses of `host`, a name or an IPv4 or IPv6 address; OSError if it has none."""
    found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    if not found:
        raise OSError(f"{host} has no address")
    return found


def connect(found: list[Address], turn: int = 0) -> socket.socket:
    """A socket connected to the first of these addresses that this system has a route to, beginning
    at number `turn`. It takes no datagrams from other addresses. OSError if there is no route."""
    failed = OSError("no address")
    first = turn % len(found)
    for family, kind, protocol, _, there in found[first:] + found[:first]:
        try:
            made = socket.socket(family, kind, protocol)
        except OSError as error:  # this host has no such family
            failed = error
            continue
        try:
            made.connect(there)
            return made
        except OSError as error:
            made.close()
            failed = error
    raise failed
