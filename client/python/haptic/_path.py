"""Whether samples go by UDP (proto/README.md, "Is the path good?"). Time is an argument, in seconds
of one steady clock; nothing here reads a clock or a socket."""

from __future__ import annotations

import collections
import enum
import secrets

_ROUND, _NEEDED, _APART_S, _ROUND_OVER_S = 5, 4, 0.020, 0.500
_BACK_OFF_S = (0.5, 1.0, 2.0, 4.0, 8.0)
_PROVEN_S = 10.0
_LEAST_SILENCE_S, _LEAST_APART_S, _OVERDUE_S = 0.100, 0.010, 0.030
_MOST_LOSS, _LOSS_OVER_S, _LEAST_PACKETS = 0.30, 1.0, 10
PROBE_PAYLOAD, KEEP_PAYLOAD = 1168, 40  # of challenges: datagrams of 1200 and 72 bytes


class PathState(enum.Enum):
    PROBING = "PROBING"
    IN_USE = "IN_USE"
    WAITING = "WAITING"
    OFF = "OFF"


class PathMachine:
    """step() returns the challenge to send now; responded() and closed() report what came back."""

    def __init__(self, period_s: float, now: float) -> None:
        self.state = PathState.PROBING
        self._period_s = period_s
        self._srtt = self._variation = 0.0
        self._back_off = 0
        self._next = now
        self._probe(now)

    def step(self, now: float) -> bytes | None:
        """A challenge to be sent at `now`, or None."""
        if self.state is PathState.WAITING and now >= self._until:
            self._probe(now)
        if self.state is PathState.PROBING:
            if self._left == 0 and now >= self._last_sent + _ROUND_OVER_S:
                self._wait(now)
            elif self._left > 0 and now >= self._next:
                self._left -= 1
                return self._challenge(now, PROBE_PAYLOAD, _APART_S)
        elif self.state is PathState.IN_USE:
            if self._pending and now - self._pending[0][1] > self.silence_s or self._lossy():
                self._wait(now)
            elif now >= self._next:
                return self._challenge(now, KEEP_PAYLOAD,
                                       max(self.silence_s / 10, _LEAST_APART_S))
        return None

    def responded(self, token: bytes, held_s: float, packets: int, newest: int, now: float) -> None:
        """A response arrived whose tag was right: the other end held the challenge for `held_s` and
        has received `packets` of this end's datagrams, with `newest` as their highest number."""
        sent = next((at for t, at in self._pending if t == token), None)
        if sent is None:
            return
        while self._pending and self._pending[0][1] <= sent:
            self._pending.popleft()
        rtt = max(now - sent - held_s, 0.0)
        if self._srtt == 0.0:
            self._srtt, self._variation = rtt, rtt / 2
        else:
            self._variation += 0.25 * (abs(self._srtt - rtt) - self._variation)
            self._srtt += 0.125 * (rtt - self._srtt)
        if self.state is PathState.PROBING:
            self._answers += 1
            if self._answers >= _NEEDED:
                self.state, self._since, self._next = PathState.IN_USE, now, now
                self._reports.clear()
                self._pending.clear()
        elif self.state is PathState.IN_USE:
            self._reports.append((now, packets, newest))
            while len(self._reports) > 2 and self._reports[1][0] <= now - _LOSS_OVER_S:
                self._reports.popleft()
            if now - self._since >= _PROVEN_S:
                self._back_off = 0

    def rekeyed(self) -> None:
        """New keys: packet numbers, and the reports of them, begin again."""
        self._reports.clear()

    def closed(self) -> None:
        self.state = PathState.OFF

    @property
    def silence_s(self) -> float:
        return max(_LEAST_SILENCE_S, 4 * self._period_s, 3 * self._srtt)

    def in_doubt(self, now: float) -> bool:
        """In use, but an answer is overdue: samples should go by the stream as well."""
        overdue = self._srtt + 4 * self._variation + _OVERDUE_S
        return (self.state is PathState.IN_USE and bool(self._pending)
                and now - self._pending[0][1] >= overdue)

    def _challenge(self, now: float, size: int, apart_s: float) -> bytes:
        token = secrets.token_bytes(8)
        self._pending.append((token, now))
        self._last_sent, self._next = now, now + apart_s
        return token.ljust(size, b"\0")

    def _lossy(self) -> bool:
        if len(self._reports) < 2 or self._reports[-1][0] - self._reports[0][0] < _LOSS_OVER_S:
            return False
        arrived = self._reports[-1][1] - self._reports[0][1]
        sent = self._reports[-1][2] - self._reports[0][2]
        return sent >= _LEAST_PACKETS and 1 - arrived / sent > _MOST_LOSS

    def _probe(self, now: float) -> None:
        self.state = PathState.PROBING
        self._left, self._answers = _ROUND, 0
        self._next = self._last_sent = now
        self._pending: collections.deque[tuple[bytes, float]] = collections.deque()
        self._reports: collections.deque[tuple[float, int, int]] = collections.deque()

    def _wait(self, now: float) -> None:
        self.state = PathState.WAITING
        self._until = now + _BACK_OFF_S[self._back_off]
        self._back_off = min(self._back_off + 1, len(_BACK_OFF_S) - 1)
