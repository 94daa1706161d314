"""From publish() to the arrival of the first state that used the sample, by whatever carrier."""

from __future__ import annotations

import time


class RoundTrip:
    """Rises at once and falls slowly: a horizon that is too near loses the onset of a contact."""

    def __init__(self) -> None:
        self.value_s = 0.0  # 0: not known yet
        self._sent: dict[int, float] = {}

    def published(self, seq: int) -> None:
        self._sent[seq] = time.monotonic()
        self._sent.pop(seq - 1024, None)

    def used(self, seq: int) -> None:
        """A state came that uses sample `seq`; 0: none."""
        at = self._sent.get(seq)
        if at is None:
            return
        for old in [known for known in self._sent if known <= seq]:
            del self._sent[old]
        took = time.monotonic() - at
        self.value_s = max(took, self.value_s + (took - self.value_s) / 16)
