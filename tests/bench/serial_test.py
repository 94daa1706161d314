"""The serial run's verdicts on made-up counters: each fails with its cause and passes without."""

import dataclasses
import unittest

from serial_verdict import Run, verdicts
from verdict import quantile

AGES = (
    (0.0005, 100),
    (0.001, 50000),
    (0.0015, 98000),
    (0.002, 99900),
    (0.1, 100000),
    (float("inf"), 100000),
)
GOOD = Run(
    100.0,
    101000,
    AGES,
    {
        "received": 111000,
        "lost": 0,
        "bad_crc": 0,
        "malformed": 0,
        "not_newer": 0,
        "sent": 110002,
        "held_back": 0,
    },
    {
        "accepted": 110000,
        "bad_crc": 0,
        "malformed": 0,
        "not_newer": 0,
        "wrong_nonce": 1,
        "without_room": 0,
        "watchdog_stops": 0,
    },
    {"device_silent": 0},
)


def failed(run: Run, target_ms: float = 2.0) -> list[str]:
    return [v.what for v in verdicts(run, target_ms) if not v.held]


def host(**changes: int) -> Run:
    return dataclasses.replace(GOOD, host={**GOOD.host, **changes})


def board(**changes: int) -> Run:
    return dataclasses.replace(GOOD, board={**GOOD.board, **changes})


class Serial(unittest.TestCase):
    def test_a_good_run_holds(self) -> None:
        self.assertEqual(failed(GOOD), [])

    def test_a_link_of_half_the_rate_does_not(self) -> None:
        self.assertEqual(failed(dataclasses.replace(GOOD, frames=50500)), ["rate"])

    def test_old_samples_do_not(self) -> None:
        self.assertEqual(failed(GOOD, target_ms=1.5), ["sample age"])

    def test_a_quantile_is_that_of_its_bucket(self) -> None:
        self.assertAlmostEqual(quantile(AGES, 0.5), 0.001)
        self.assertAlmostEqual(quantile(AGES, 0.74), 0.00125)
        self.assertEqual(quantile(((0.001, 0), (float("inf"), 10)), 0.5), float("inf"))

    def test_a_frame_lost_without_a_reason_is_found_up(self) -> None:
        self.assertEqual(failed(host(lost=1)), ["frames up"])

    def test_one_with_a_reason_is_allowed(self) -> None:
        self.assertEqual(failed(host(lost=1, bad_crc=1)), [])
        self.assertEqual(
            failed(dataclasses.replace(host(lost=2), board={**GOOD.board, "without_room": 2})), []
        )

    def test_a_frame_lost_without_a_reason_is_found_down(self) -> None:
        self.assertEqual(failed(board(accepted=109990)), ["frames down"])
        self.assertEqual(
            failed(board(accepted=110003)), ["frames down"]
        )  # nor may the board count what was not sent
        self.assertEqual(failed(board(accepted=109990, bad_crc=10)), [])

    def test_a_watchdog_stop_or_a_fault_is_told(self) -> None:
        self.assertEqual(failed(board(watchdog_stops=1)), ["undisturbed"])
        self.assertEqual(
            failed(dataclasses.replace(GOOD, faults={"device_silent": 1})), ["undisturbed"]
        )


if __name__ == "__main__":
    unittest.main()
