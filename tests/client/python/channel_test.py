"""Datagrams: the test vectors of proto/README.md, and what must be dropped."""

import os
import re
import unittest

from haptic._channel import Keys, ReplayWindow, Type

README = os.path.join(os.environ["HAPTIC_SCENES"], "../../proto/README.md")


def keys() -> Keys:
    """The keys of the test vectors, read from the page."""
    with open(README, encoding="utf-8") as page:
        rows = dict(re.findall(r"^\| (up|down) \| `([0-9a-f]{32}` \| `[0-9a-f]{8})` \|$",
                               page.read(), re.M))
    up, down = (tuple(map(bytes.fromhex, rows[way].split("` | `"))) for way in ("up", "down"))
    return Keys.of(0xC0FFEE01, *up, *down)


def vectors() -> dict[str, tuple[str, int, bytes, bytes]]:
    with open(README, encoding="utf-8") as page:
        rows = re.findall(r"^\| (\w+) \| (up|down) \| (\d+) \| `([0-9a-f-]+)` \| `([0-9a-f]+)` \|$",
                          page.read(), re.M)
    return {name: (way, int(number), bytes.fromhex(payload.strip("-")), bytes.fromhex(datagram))
            for name, way, number, payload, datagram in rows}


class Vectors(unittest.TestCase):
    def test_there_are_five(self) -> None:
        self.assertEqual(set(vectors()), {"proxy", "state", "challenge", "response", "close"})

    def test_samples_are_sealed_exactly(self) -> None:
        kinds = {"proxy": Type.PROXY, "challenge": Type.PATH_CHALLENGE, "close": Type.CLOSE}
        for name, kind in kinds.items():
            way, number, payload, datagram = vectors()[name]
            self.assertEqual(way, "up")
            ours = keys()
            ours.sent = number - 1
            self.assertEqual(ours.seal(kind, payload), datagram, name)

    def test_what_comes_down_is_opened(self) -> None:
        for name, kind in {"state": Type.STATE, "response": Type.PATH_RESPONSE}.items():
            _, _, payload, datagram = vectors()[name]
            self.assertEqual(keys().open(datagram), (kind, payload), name)


class Drops(unittest.TestCase):
    def setUp(self) -> None:
        self.state = vectors()["state"][3]

    def test_any_single_bit_that_flips(self) -> None:
        for bit in range(8 * len(self.state)):
            damaged = bytearray(self.state)
            damaged[bit // 8] ^= 1 << bit % 8
            self.assertIsNone(keys().open(bytes(damaged)), f"bit {bit}")

    def test_any_truncation(self) -> None:
        for size in range(len(self.state)):
            self.assertIsNone(keys().open(self.state[:size]), f"{size} bytes")

    def test_a_replay(self) -> None:
        ours = keys()
        self.assertIsNotNone(ours.open(self.state))
        self.assertIsNone(ours.open(self.state))

    def test_what_was_our_own(self) -> None:
        self.assertIsNone(keys().open(vectors()["proxy"][3]))

    def test_worn_out_keys_seal_nothing(self) -> None:
        ours = keys()
        ours.sent = 2**32
        self.assertIsNone(ours.seal(Type.CLOSE, b""))


class Window(unittest.TestCase):
    def test_keeps_the_newest_1024(self) -> None:
        window, seen = ReplayWindow(), set()
        number = 1
        for i in range(5000):
            number = max(1, number + (i * 7919) % 61 - 25)  # up and down, often the same again
            fresh = number not in seen and number > max(seen, default=0) - 1024
            self.assertEqual(window.fresh(number), fresh, f"{i}: {number}")
            if fresh:
                window.commit(number)
                seen.add(number)

    def test_1024_behind_is_out(self) -> None:
        window = ReplayWindow()
        window.commit(2000)
        self.assertTrue(window.fresh(2000 - 1023))
        self.assertFalse(window.fresh(2000 - 1024))


if __name__ == "__main__":
    unittest.main()
