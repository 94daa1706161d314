"""One line of a long run's verdict: the rule, whether it held, and the figures."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class Verdict:
    what: str
    held: bool
    figures: str

    def __str__(self) -> str:
        return f"{self.what:12} {'held' if self.held else 'NOT HELD'}: {self.figures}"
