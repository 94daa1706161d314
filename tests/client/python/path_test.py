"""The path's states on virtual time, by the table of proto/README.md."""

import unittest

from haptic._path import PathMachine, PathState

MS = 1e-3


class Far:
    """The other end: answers what reaches it, `delay_s` later; `up` says what does."""

    def __init__(self, period_s: float = 0.01, delay_s: float = 0.001) -> None:
        self.now = 100.0
        self.machine = PathMachine(period_s, self.now)
        self.delay_s = delay_s
        self.up = True
        self.sent: list[tuple[float, int]] = []
        self.packets = self.newest = 0
        self._answers: list[tuple[float, bytes]] = []

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            self.now += 1 * MS
            due = [a for a in self._answers if a[0] <= self.now]
            self._answers = [a for a in self._answers if a[0] > self.now]
            for _, token in due:
                self.machine.responded(token, 0.0, self.packets, self.newest, self.now)
            challenge = self.machine.step(self.now)
            if challenge is None:
                continue
            self.sent.append((self.now, len(challenge)))
            self.newest += 1
            if self.up:
                self.packets += 1
                self._answers.append((self.now + self.delay_s, challenge[:8]))


class Path(unittest.TestCase):
    def test_four_of_five_answers_suffice(self) -> None:
        far = Far()
        far.run(0.050)  # three challenges
        self.assertIs(far.machine.state, PathState.PROBING)
        far.run(0.050)
        self.assertIs(far.machine.state, PathState.IN_USE)
        self.assertEqual([size for _, size in far.sent[:4]], [1168] * 4)
        self.assertAlmostEqual(far.sent[1][0] - far.sent[0][0], 0.020, delta=1.5 * MS)

    def test_the_back_off_doubles(self) -> None:
        far = Far()
        far.up = False
        far.run(40.0)
        rounds = [far.sent[i][0] for i in range(0, len(far.sent), 5)]
        gaps = [b - a for a, b in zip(rounds, rounds[1:])]
        # A round takes 4 x 20 ms and 500 ms more, then 0.5, 1, 2, 4, 8, 8 s.
        for gap, back_off in zip(gaps, (0.5, 1, 2, 4, 8, 8)):
            self.assertAlmostEqual(gap, 0.58 + back_off, delta=5 * MS)

    def test_doubt_comes_before_silence(self) -> None:
        far = Far()
        far.run(1.0)
        self.assertFalse(far.machine.in_doubt(far.now))
        far.up = False
        cut = far.now
        while not far.machine.in_doubt(far.now):
            far.run(1 * MS)
        # 1 ms round trip, 30 ms, and up to 10 ms until the next challenge.
        self.assertLess(far.now - cut, 0.050)
        self.assertIs(far.machine.state, PathState.IN_USE)
        far.up = True
        far.run(0.020)
        self.assertFalse(far.machine.in_doubt(far.now))

    def test_the_limit_of_silence(self) -> None:
        self.assertAlmostEqual(Far(period_s=0.01).machine.silence_s, 0.100)
        self.assertAlmostEqual(Far(period_s=0.05).machine.silence_s, 0.200)
        far = Far(delay_s=0.080)
        far.run(1.0)
        self.assertAlmostEqual(far.machine.silence_s, 0.240, delta=0.006)

    def test_silence_ends_its_use(self) -> None:
        far = Far()
        far.run(1.0)
        self.assertIs(far.machine.state, PathState.IN_USE)
        far.up = False
        far.run(0.095)
        self.assertIs(far.machine.state, PathState.IN_USE)
        far.run(0.020)
        self.assertIs(far.machine.state, PathState.WAITING)

    def test_it_returns_with_the_far_end(self) -> None:
        far = Far()
        far.run(1.0)
        far.up = False
        far.run(0.2)
        far.up = True
        far.run(0.7)
        self.assertIs(far.machine.state, PathState.IN_USE)

    def test_much_loss_ends_its_use(self) -> None:
        for lost, ends in ((0.25, False), (0.35, True)):
            far = Far()
            far.run(0.2)
            far.machine.responded(b"", 0.0, 0, 0, far.now)  # not ours: changes nothing
            for _ in range(120):  # 1.2 s of data, of which a share is lost
                far.newest += 99
                far.packets += round(99 * (1 - lost))
                far.run(0.010)
            self.assertIs(far.machine.state,
                          PathState.WAITING if ends else PathState.IN_USE, f"{lost}")

    def test_a_closed_path_stays_off(self) -> None:
        far = Far()
        far.run(1.0)
        far.machine.closed()
        count = len(far.sent)
        far.run(30.0)
        self.assertIs(far.machine.state, PathState.OFF)
        self.assertEqual(len(far.sent), count)


if __name__ == "__main__":
    unittest.main()
