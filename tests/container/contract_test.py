"""The verdicts of contract.py on made-up records: each bites, and knows what it cannot tell."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

CONTRACT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "contract.py")
MS = 1_000_000
PROMISED, NOT, CANNOT_TELL = 0, 1, 3


def record(ms: float, *, age_ms: float = 5, force: float = 3.0, **said: object) -> dict:
    return {"server_time_ns": int(ms * MS), "proxy_age_us": age_ms * 1000, "tau_elastic": [force],
            "staleness": "FRESH", "state": "ENGAGED", "gain": 1.0, "transport": "UDP",
            "faults": ""} | said


def pressed(until_ms: int) -> list[dict]:
    return [record(ms) for ms in range(0, until_ms, 4)]


def silenced(zero_after_ms: int, rest_ms: int = 1200) -> list[dict]:
    """Pressed for 400 ms, the last sample came at 391 ms; force until `zero_after_ms` behind it."""
    rows = pressed(400)
    for ms in range(400, 400 + rest_ms, 4):
        age = ms - 391
        stale = "HOLD" if age < 100 else "FADE" if age < 180 else "LOST"
        if age < zero_after_ms:
            rows.append(record(ms, age_ms=age, force=1.0, staleness=stale, gain=0.2))
        else:
            rows.append(record(ms, age_ms=age, force=0.0, staleness=stale, state="ARMED", gain=0.0))
    return rows


BY_GRPC = {"transport": "GRPC"}
IN_TIME, LATE = silenced(180), silenced(220)
BLIND = [row for row in IN_TIME if not 540 < row["server_time_ns"] / MS < 640]
EARLIER = [*(record(ms - 1000, staleness="LOST", force=0.0, state="ARMED", gain=0.0)
             for ms in range(0, 100, 4)), *(record(ms - 900, gain=0.1) for ms in range(0, 800, 4))]
SLOW = [record(1600 + ms, state="ENGAGING", gain=ms / 200) for ms in range(0, 200, 4)]
FADING = [record(400 + 4 * i, state="RELEASING", gain=1 - i / 20) for i in range(19)]

CASES = [
    ("two seconds of force by one carrier", "only UDP", pressed(2500), PROMISED),
    ("less than two seconds", "only UDP", pressed(1500), NOT),
    ("force by another carrier", "only GRPC", pressed(2500), NOT),
    ("force by a second carrier", "only UDP", [*pressed(2500), record(2504, **BY_GRPC)], NOT),
    ("a second carrier without force", "only UDP",
     [*pressed(2500), record(2504, force=0.0, **BY_GRPC)], PROMISED),
    ("force that is gone in time", "silence", IN_TIME, PROMISED),
    ("force after 200 ms", "silence", LATE, NOT),
    ("force that comes back unasked", "silence",
     [*IN_TIME, record(1700, staleness="LOST", state="ARMED")], NOT),
    ("an observer that saw nothing meanwhile", "silence", BLIND, CANNOT_TELL),
    ("no force before it", "silence", [row | {"tau_elastic": [0.0]} for row in IN_TIME],
     CANNOT_TELL),
    ("an earlier loss does not count", "silence", [*EARLIER, *IN_TIME], PROMISED),
    ("an earlier loss, force after 200 ms", "silence", [*EARLIER, *LATE], NOT),
    ("less than a second since the newest loss", "quiet 1", silenced(180, rest_ms=800), NOT),
    ("a second since the newest loss", "quiet 1", silenced(180, rest_ms=1400), PROMISED),
    ("a gain that rises slowly", "ramp", [*IN_TIME, *SLOW, record(1800)], PROMISED),
    ("a gain that jumps", "ramp", [*IN_TIME, *SLOW[:10], record(1640)], NOT),
    ("four seconds by the server's clock", "spans 4", pressed(4100), PROMISED),
    ("less than four seconds", "spans 4", pressed(3900), NOT),
    ("a loss without force", "safe", IN_TIME, PROMISED),
    ("a loss with force", "safe", LATE, NOT),
    ("a gain that jumps after a loss", "safe", [*IN_TIME, record(1640)], NOT),
    ("a fault", "safe", [*pressed(400), record(404, faults="LOOP_LATE")], NOT),
    ("a server that ends as force fades", "closing", [*pressed(400), *FADING], PROMISED),
    ("a server that ends under force", "closing", pressed(400), CANNOT_TELL),
]


class Contract(unittest.TestCase):
    def test_each_verdict(self) -> None:
        for name, command, rows, verdict in CASES:
            with self.subTest(name), tempfile.NamedTemporaryFile("w", encoding="utf-8") as file:
                file.writelines(json.dumps(row) + "\n" for row in rows)
                file.flush()
                kind, *argument = command.split()
                got = subprocess.run([sys.executable, CONTRACT, kind, file.name, *argument],
                                     capture_output=True).returncode
                self.assertEqual(got, verdict)


if __name__ == "__main__":
    unittest.main()
