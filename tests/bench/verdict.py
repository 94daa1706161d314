"""One line of what a long run says: what was asked, whether it held, by which figures."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class Verdict:
    what: str
    held: bool
    figures: str

    def __str__(self) -> str:
        return f"{self.what:12} {'held' if self.held else 'NOT HELD'}: {self.figures}"
