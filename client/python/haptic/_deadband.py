"""Which samples the server needs. It goes on with a sample's planes at 1 kHz, so a sample that says
what the server finds by itself is no news: haptic/client/deadband.hpp has the rule, and this is
the same in Python."""

from __future__ import annotations

import collections
import dataclasses
import math
from collections.abc import Sequence

from ._sample import difference
from ._types import Plane, Proxy
from .v1 import session_pb2 as wire

_MOST_LAWS = 1024  # half a second at the highest rate
_MOST_OF_FRESH = 0.9  # of fresh_end; the rest is the network's jitter
_RIGID = 1e-6  # compliance of a rigid plane by |gradient|^2
_SOFTNESS = 0.1  # of a compliance; less of a change is hardly felt
_ECHO = 1e-6  # held as near to its probe as this it is free there
_STEPS = 20  # of Newton, at most
_EXACT = 1e-3  # of the width

Vector = Sequence[float]


def _plus(a: Vector, b: Vector) -> list[float]:
    return [x + y for x, y in zip(a, b, strict=True)]


def _gap(plane: Plane, x_0: Vector, z: Vector, t: float) -> tuple[float, list[float]]:
    """At x = x_0 + z, t seconds after the sample, and its gradient."""
    gap = plane.offset + plane.velocity * t - sum(
        n * (x + d) for n, x, d in zip(plane.normal, x_0, z, strict=True))
    gradient = [-n for n in plane.normal]
    k = row = 0
    while k < len(plane.curvature):
        for column in range(row + 1):
            i, j, h = plane.first_coordinate + row, plane.first_coordinate + column, \
                plane.curvature[k]
            gap += (0.5 if i == j else 1.0) * h * z[i] * z[j]
            gradient[i] += h * z[j]
            if i != j:
                gradient[j] += h * z[i]
            k += 1
        row += 1
    return gap, gradient


def _solve_symmetric(a: list[list[float]], b: list[float]) -> list[float]:
    """b' of a b' = b; a: symmetric, positive definite. Overwrites both."""
    n = len(b)
    for i in range(n):
        for r in range(i + 1, n):
            share = a[r][i] / a[i][i]
            if share != 0.0:
                for c in range(i, n):
                    a[r][c] -= share * a[i][c]
                b[r] -= share * b[i]
    for i in reversed(range(n)):
        b[i] = (b[i] - sum(a[i][c] * b[c] for c in range(i + 1, n))) / a[i][i]
    return b


def _fits(plane: Plane, n_x: int) -> bool:
    """Whether the server can use the plane so; it refuses others, and they are always news."""
    n = math.isqrt(2 * len(plane.curvature))
    return (len(plane.normal) == n_x and n * (n + 1) // 2 == len(plane.curvature) and
            0 <= plane.first_coordinate <= n_x - n and plane.mass == 0.0)


@dataclasses.dataclass(slots=True)
class _Law:
    """What the server makes of a sample."""

    seq: int
    at: float  # s
    proxy: Proxy
    probe: list[float]  # beside the proxy's position, or the held one's; empty: not known
    anchor: list[float]  # the client's own proxy less what the planes say


class Deadband:
    """`width`: m or rad, of each coordinate; 0: every sample is news. `period_s`: of publish(),
    `fresh_end_s`: of the session."""

    def __init__(self, kinds: Sequence[str], width: float, period_s: float,
                 fresh_end_s: float) -> None:
        self._kinds, self._width = kinds, width
        self._longest_s = _MOST_OF_FRESH * fresh_end_s - period_s
        self._used = 0
        self._laws: collections.deque[_Law] = collections.deque(maxlen=_MOST_LAWS)

    def used(self, seq: int) -> None:
        """A state used sample `seq`; 0: none."""
        self._used = max(self._used, seq)
        while self._laws and self._laws[0].seq < self._used:
            self._laws.popleft()

    def is_news(self, seq: int, proxy: Proxy, x_probe: Vector, now_s: float) -> bool:
        """Whether a sample is news. If so it counts as sent `now_s` under the number `seq`, above
        all before. `x_probe`: what it was computed from; empty: not known."""
        if not self._width > 0.0:
            return True
        law = self._law(seq, proxy, x_probe, now_s)
        known = (bool(self._laws) and self._laws[0].seq == self._used and
                 now_s - self._laws[-1].at <= self._longest_s)
        if known and all(self._same(old, law) for old in self._laws):
            return False
        self._laws.append(law)
        return True

    def _law(self, seq: int, proxy: Proxy, x_probe: Vector, now_s: float) -> _Law:
        law, n_x = _Law(seq, now_s, proxy, [], []), len(self._kinds)
        if proxy.mode == wire.PROXY_MODE_HELD and len(proxy.position) == len(x_probe) == n_x:
            law.probe = list(x_probe)
        if (proxy.mode == wire.PROXY_MODE_PLANES and len(proxy.position) == len(x_probe) == n_x and
                all(_fits(plane, n_x) for plane in proxy.planes)):
            away = difference(self._kinds, x_probe, proxy.position)
            anchored = any(plane.id for plane in proxy.planes)
            law.anchor = [-z for z in self._solve(proxy, away, 0.0)] if anchored else [0.0] * n_x
            if self._shifts_one_gap(proxy, law.anchor):
                law.probe = _plus(proxy.position, away)
        return law

    def _shifts_one_gap(self, proxy: Proxy, anchor: Vector) -> bool:
        """Whether the server's shift of the gaps is this way of the proxy: within the width it lies
        along the gradient of the only plane that is touched."""
        none, touched = [0.0] * len(anchor), []
        for plane in proxy.planes:
            gap, g = _gap(plane, proxy.position, none, 0.0)
            if gap <= self._width * math.hypot(*g):
                touched.append(g)
        if len(touched) == 1:
            g = touched[0]
            share = sum(a * b for a, b in zip(anchor, g, strict=True)) / sum(b * b for b in g)
            anchor = [a - share * b for a, b in zip(anchor, g, strict=True)]
        return all(abs(part) <= self._width for part in anchor)

    def _free(self, law: _Law) -> list[bool]:
        """Per coordinate of a held proxy: it goes on with the probe."""
        return [abs(d) <= _ECHO
                for d in difference(self._kinds, law.proxy.position, law.probe)]

    def _near(self, a: Vector, b: Vector) -> bool:
        return all(abs(d) <= self._width for d in difference(self._kinds, a, b))

    def _solve(self, proxy: Proxy, probe: Vector, t: float) -> list[float]:
        """The proxy of the planes, less the sample's position; `probe` is less it too. By Newton's
        steps on 1/2 |x - probe|^2 + 1/2 sum min(0, gap)^2 / compliance."""
        n, z = len(probe), list(probe)
        for _ in range(_STEPS):
            a = [[float(i == j) for j in range(n)] for i in range(n)]
            b = [p - x for p, x in zip(probe, z, strict=True)]
            for plane in proxy.planes:
                gap, g = _gap(plane, proxy.position, z, t)
                compliance = max(plane.compliance, _RIGID * sum(part * part for part in g))
                if not (gap < 0.0 < compliance):
                    continue
                touched = [i for i in range(n) if g[i] != 0.0]  # the others are of another finger
                for i in touched:
                    b[i] -= gap * g[i] / compliance
                    for j in touched:
                        a[i][j] += g[i] * g[j] / compliance
            step = _solve_symmetric(a, b)
            z = _plus(z, step)
            if all(abs(part) <= _EXACT * self._width for part in step):
                break
        return z

    def _predict(self, law: _Law, probe: Vector, t: float) -> list[float]:
        x = self._solve(law.proxy, difference(self._kinds, probe, law.proxy.position), t)
        return _plus(_plus(x, law.proxy.position), law.anchor)

    def _same_surface(self, told: Plane, now: Plane, old: _Law, law: _Law, ahead: float) -> bool:
        if ((told.id, len(told.curvature), told.uncertainty is None) !=
                (now.id, len(now.curvature), now.uncertainty is None) or
                (now.uncertainty or 0.0) > (told.uncertainty or 0.0)):
            return False
        x_0, x = old.proxy.position, law.proxy.position
        z, none = difference(self._kinds, x, x_0), [0.0] * len(x)
        for t in (0.0, ahead):
            off = _gap(told, x_0, z, law.at - old.at + t)[0] - _gap(now, x, none, t)[0]
            if not abs(off) <= self._width * math.hypot(*now.normal):
                return False
        return abs(told.compliance - now.compliance) <= _SOFTNESS * now.compliance

    def _same(self, old: _Law, law: _Law) -> bool:
        told, now, used = old.proxy, law.proxy, self._laws[0]
        if told.mode != now.mode or now.mode == wire.PROXY_MODE_FREE:
            return told.mode == now.mode
        if not (old.probe and law.probe and used.probe) or len(told.planes) != len(now.planes):
            return False
        if now.mode == wire.PROXY_MODE_HELD:
            return (self._near(told.position, now.position) and
                    self._free(old) == self._free(law))
        age, ahead = law.at - old.at, law.at - used.at
        if not all(self._same_surface(a, b, old, law, ahead)
                   for a, b in zip(told.planes, now.planes, strict=True)):
            return False
        further = _plus(law.probe, difference(self._kinds, law.probe, used.probe))
        return (self._near(self._predict(old, law.probe, age), self._predict(law, law.probe, 0.0))
                and self._near(self._predict(old, further, age + ahead),
                               self._predict(law, further, ahead)))
