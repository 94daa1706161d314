"""The verdicts of contract.py on made-up records: each bites, and knows what it cannot tell."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

CONTRACT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "contract.py")
MS = 1_000_000


def record(
    ms: float,
    *,
    age_ms: float = 5,
    force: float = 3.0,
    staleness: str = "FRESH",
    state: str = "ENGAGED",
    gain: float = 1.0,
) -> dict:
    return {
        "server_time_ns": int(ms * MS),
        "proxy_age_us": age_ms * 1000,
        "tau_elastic": [force],
        "staleness": staleness,
        "state": state,
        "gain": gain,
        "transport": "UDP",
        "faults": "",
    }


def pressed(until_ms: int) -> list[dict]:
    return [record(ms) for ms in range(0, until_ms, 4)]


def silenced(zero_after_ms: int, rest_ms: int = 1200) -> list[dict]:
    """Pressed for 400 ms, the last sample came at 391 ms; force until `zero_after_ms` behind it."""
    rows = pressed(400)
    for ms in range(400, 400 + rest_ms, 4):
        age = ms - 391
        stale = "HOLD" if age < 100 else "FADE" if age < 180 else "LOST"
        on = age < zero_after_ms
        rows.append(
            record(
                ms,
                age_ms=age,
                force=1.0 if on else 0.0,
                staleness=stale,
                state="ENGAGED" if on else "ARMED",
                gain=0.2 if on else 0.0,
            )
        )
    return rows


class Contract(unittest.TestCase):
    def judge(self, rows: list[dict], *command: str) -> int:
        with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
            file.writelines(json.dumps(row) + "\n" for row in rows)
            file.flush()
            return subprocess.run(
                [sys.executable, CONTRACT, command[0], file.name, *command[1:]], capture_output=True
            ).returncode

    def test_force_by_one_carrier_alone_takes_two_seconds_to_be_seen(self) -> None:
        self.assertEqual(self.judge(pressed(2500), "only", "UDP"), 0)
        self.assertEqual(self.judge(pressed(1500), "only", "UDP"), 1)
        self.assertEqual(self.judge(pressed(2500), "only", "GRPC"), 1)
        mixed = [*pressed(2500), {**record(2504), "transport": "GRPC"}]
        self.assertEqual(self.judge(mixed, "only", "UDP"), 1)
        without = [{**record(2504, force=0.0), "transport": "GRPC"}]
        self.assertEqual(self.judge([*pressed(2500), *without], "only", "UDP"), 0)

    def test_force_that_is_gone_in_time_is_as_promised(self) -> None:
        self.assertEqual(self.judge(silenced(180), "silence"), 0)

    def test_force_after_200_ms_is_not(self) -> None:
        self.assertEqual(self.judge(silenced(220), "silence"), 1)

    def test_force_that_comes_back_unasked_is_not(self) -> None:
        self.assertEqual(
            self.judge([*silenced(180), record(1700, staleness="LOST", state="ARMED")], "silence"),
            1,
        )

    def test_an_observer_that_saw_nothing_meanwhile_cannot_tell(self) -> None:
        rows = [row for row in silenced(180) if not 540 < row["server_time_ns"] / MS < 640]
        self.assertEqual(self.judge(rows, "silence"), 3)

    def test_without_force_before_it_nothing_can_be_told(self) -> None:
        self.assertEqual(
            self.judge([{**row, "tau_elastic": [0.0]} for row in silenced(180)], "silence"), 3
        )

    def test_a_loss_before_the_trouble_is_not_the_one_that_counts(self) -> None:
        earlier = [
            record(ms - 1000, staleness="LOST", force=0.0, state="ARMED", gain=0.0)
            for ms in range(0, 100, 4)
        ]
        again = [record(ms - 900, gain=0.1) for ms in range(0, 800, 4)]
        self.assertEqual(self.judge([*earlier, *again, *silenced(180)], "silence"), 0)
        self.assertEqual(self.judge([*earlier, *again, *silenced(220)], "silence"), 1)

    def test_quiet_waits_for_the_newest_loss(self) -> None:
        self.assertEqual(self.judge(silenced(180, rest_ms=800), "quiet", "1"), 1)
        self.assertEqual(self.judge(silenced(180, rest_ms=1400), "quiet", "1"), 0)

    def test_a_gain_that_jumps_is_no_ramp(self) -> None:
        slow = [record(1600 + ms, state="ENGAGING", gain=ms / 200) for ms in range(0, 200, 4)]
        self.assertEqual(self.judge([*silenced(180), *slow, record(1800)], "ramp"), 0)
        self.assertEqual(self.judge([*silenced(180), *slow[:10], record(1640)], "ramp"), 1)

    def test_spans_counts_the_servers_time(self) -> None:
        self.assertEqual(self.judge(pressed(4100), "spans", "4"), 0)
        self.assertEqual(self.judge(pressed(3900), "spans", "4"), 1)

    def test_a_loss_is_safe_without_force(self) -> None:
        self.assertEqual(self.judge(silenced(180), "safe"), 0)
        self.assertEqual(self.judge(silenced(220), "safe"), 1)
        self.assertEqual(self.judge([*silenced(180), record(1640)], "safe"), 1)  # the gain jumps
        self.assertEqual(
            self.judge([*pressed(400), {**record(404), "faults": "LOOP_LATE"}], "safe"), 1
        )

    def test_a_server_that_ends_under_force_is_not_seen_to_fade(self) -> None:
        fading = [record(400 + 4 * i, state="RELEASING", gain=1 - i / 20) for i in range(19)]
        self.assertEqual(self.judge([*pressed(400), *fading], "closing"), 0)
        self.assertEqual(self.judge(pressed(400), "closing"), 3)


if __name__ == "__main__":
    unittest.main()
