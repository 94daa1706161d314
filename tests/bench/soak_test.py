"""The soak's verdicts on made-up seconds: each fails with its cause and passes without."""

import dataclasses
import random
import unittest

from soak_verdict import Second, at_least, verdicts


def quiet(seconds: int = 600) -> list[Second]:
    """As of a server without a flaw, on a machine that stumbles now and then."""
    draw = random.Random(7)
    return [
        Second(
            29e6 + draw.randrange(3) * 4096,
            int(draw.random() < 0.02),
            draw.uniform(55, 75),
            int(draw.random() < 0.02),
            draw.uniform(50, 70),
        )
        for _ in range(seconds)
    ]


def held(rows: list[Second]) -> dict[str, bool]:
    return {v.what: v.held for v in verdicts(rows)}


class Soak(unittest.TestCase):
    def test_a_quiet_run_holds(self) -> None:
        self.assertEqual(held(quiet()), {"memory": True, "missed": True, "lateness": True})

    def test_a_leak_of_one_kilobyte_a_second_does_not(self) -> None:
        rows = [
            dataclasses.replace(r, resident_bytes=r.resident_bytes + 1024 * i)
            for i, r in enumerate(quiet())
        ]
        self.assertEqual(held(rows), {"memory": False, "missed": True, "lateness": True})

    def test_a_loop_that_misses_once_in_ten_seconds_does_not(self) -> None:
        rows = [
            dataclasses.replace(r, missed=r.missed + (i % 10 == 0)) for i, r in enumerate(quiet())
        ]
        self.assertEqual(held(rows), {"memory": True, "missed": False, "lateness": True})

    def test_lateness_that_grows_by_a_half_does_not(self) -> None:
        rows = [
            dataclasses.replace(r, p99_us=r.p99_us * (1 + 0.5 * i / 600))
            for i, r in enumerate(quiet())
        ]
        self.assertEqual(held(rows), {"memory": True, "missed": True, "lateness": False})

    def test_what_befell_the_machine_is_not_the_servers(self) -> None:
        rows = [
            dataclasses.replace(
                r, p99_us=3 * r.p99_us, bare_p99_us=3 * r.bare_p99_us, missed=2, bare_missed=2
            )
            if i > 500
            else r
            for i, r in enumerate(quiet())
        ]
        self.assertEqual(held(rows), {"memory": True, "missed": True, "lateness": True})

    def test_less_than_ten_seconds_are_no_soak(self) -> None:
        with self.assertRaises(ValueError):
            verdicts(quiet(9))

    def test_the_tail_of_the_even_binomial(self) -> None:
        self.assertEqual(at_least(0, 0), 1.0)
        self.assertEqual(at_least(3, 3), 0.125)
        self.assertAlmostEqual(at_least(520, 1000), at_least(521, 1002), delta=0.01)


if __name__ == "__main__":
    unittest.main()
