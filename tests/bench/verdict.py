"""A long run's verdict, a line of it each, and the quantiles of its histograms."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence


@dataclasses.dataclass(frozen=True)
class Verdict:
    """The rule, whether it held, and the figures."""

    what: str
    held: bool
    figures: str

    def __str__(self) -> str:
        return f"{self.what:12} {'held' if self.held else 'NOT HELD'}: {self.figures}"


def quantile(buckets: Sequence[tuple[float, int]], share: float) -> float:
    """Of (upper bound, how many in all up to it), +inf last: linear within a bucket; infinite
    beyond the last bound."""
    wanted = share * buckets[-1][1]
    low_bound = low_count = 0.0
    for bound, count in buckets:
        if count >= wanted:
            part = (wanted - low_count) / (count - low_count) if count > low_count else 0.0
            return low_bound + part * (bound - low_bound)
        low_bound, low_count = bound, count
    return float("inf")
