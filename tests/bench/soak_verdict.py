"""Judges a soak by its seconds: memory stays flat, no more missed deadlines than a bare loop has,
lateness as at the start."""

from __future__ import annotations

import dataclasses
import math
import random
import statistics
from collections.abc import Sequence

from verdict import Verdict

GROWTH_ALLOWED = 0.01  # of resident memory, or
GROWTH_ALLOWED_BYTES = 256 * 1024  # which is a few thread stacks' worth of touched pages
CHANCE = 0.01
ROUNDS = 1000  # of the bootstrap; its seed is fixed, so that judging a table twice gives the same


@dataclasses.dataclass(frozen=True)
class Second:
    resident_bytes: float
    missed: int
    p99_us: float
    bare_missed: int
    bare_p99_us: float


def verdicts(rows: Sequence[Second]) -> list[Verdict]:
    """Start and end: the first and the last tenth of the rows, which are in order of time. At least
    10 rows."""
    if len(rows) < 10:
        raise ValueError(f"{len(rows)} seconds: at least 10 are needed")
    tenth = len(rows) // 10
    return [
        memory(rows[:tenth], rows[-tenth:]),
        missed(rows),
        lateness(rows[:tenth], rows[-tenth:]),
    ]


def memory(start: Sequence[Second], end: Sequence[Second]) -> Verdict:
    before, after = (statistics.median(r.resident_bytes for r in part) for part in (start, end))
    allowed = max(GROWTH_ALLOWED * before, GROWTH_ALLOWED_BYTES)
    return Verdict(
        "memory",
        after - before <= allowed,
        f"{before / 1e6:.2f} MB resident at the start, {after / 1e6:.2f} MB at the end",
    )


def missed(rows: Sequence[Second]) -> Verdict:
    """A sign test: misses come in bursts, so seconds are counted. Of those in which one loop alone
    missed, or one missed more, hapticd may have no more than chance gives it with even odds."""
    worse = sum(r.missed > r.bare_missed for r in rows)
    better = sum(r.missed < r.bare_missed for r in rows)
    by_chance = at_least(worse, worse + better)
    return Verdict(
        "missed",
        by_chance > CHANCE,
        f"{sum(r.missed for r in rows)} deadlines, "
        f"the bare loop {sum(r.bare_missed for r in rows)}; "
        f"worse in {worse} s, better in {better} s (by chance: p = {by_chance:.2g})",
    )


def lateness(start: Sequence[Second], end: Sequence[Second]) -> Verdict:
    """End over start, divided by the same of the bare loop: this removes what the machine did."""

    def ratio(a: Sequence[Second], b: Sequence[Second]) -> float:
        def median(part: Sequence[Second], name: str) -> float:
            return max(statistics.median(getattr(r, name) for r in part), 1e-3)

        return (median(b, "p99_us") / median(a, "p99_us")) / (
            median(b, "bare_p99_us") / median(a, "bare_p99_us")
        )

    draw = random.Random(1)
    drawn = sorted(
        ratio(draw.choices(start, k=len(start)), draw.choices(end, k=len(end)))
        for _ in range(ROUNDS)
    )
    low, high = drawn[int(0.025 * ROUNDS)], drawn[int(0.975 * ROUNDS)]
    before, after = (statistics.median(r.p99_us for r in part) for part in (start, end))
    bare_before, bare_after = (
        statistics.median(r.bare_p99_us for r in part) for part in (start, end)
    )
    return Verdict(
        "lateness",
        low <= 1.0,
        f"p99 {before:.0f} us at the start, {after:.0f} us at the end "
        f"(bare loop {bare_before:.0f}, "
        f"{bare_after:.0f}); {ratio(start, end):.2f} x "
        f"[{low:.2f}, {high:.2f}] of the bare loop's change",
    )


def at_least(count: int, of: int) -> float:
    """P(X >= count) for X ~ B(of, 1/2)."""
    if of > 1000:  # normal, with the correction for continuity
        return 0.5 * math.erfc((count - 0.5 - of / 2) / math.sqrt(of / 2))
    return sum(math.comb(of, k) for k in range(count, of + 1)) / 2**of
