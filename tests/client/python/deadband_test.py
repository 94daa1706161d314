"""Which samples the server needs: the vectors that the C++ library is tested by too."""

import json
import pathlib
import unittest

from haptic._deadband import Deadband
from haptic._types import Plane, Proxy
from haptic.v1 import session_pb2 as wire

MODES = {"free": wire.PROXY_MODE_FREE, "held": wire.PROXY_MODE_HELD,
         "planes": wire.PROXY_MODE_PLANES}
VECTORS = json.loads(pathlib.Path(__file__).parents[1].joinpath("deadband.json").read_text())


def plane(told: dict) -> Plane:
    return Plane(**{"normal": (1.0, 0.0), **told})


class Vectors(unittest.TestCase):
    def test_each_step_of_each_case(self) -> None:
        for case in VECTORS["cases"]:
            deadband = Deadband(case.get("kinds", ("linear", "linear")), VECTORS["width"],
                                1.0 / VECTORS["rate_hz"], VECTORS["fresh_end_s"])
            seq = 1
            for k, step in enumerate(case["steps"]):
                with self.subTest(case["name"], step=k):
                    deadband.used(step.get("used", 0))
                    proxy = Proxy(MODES[step["mode"]], tuple(step.get("position", ())),
                                  tuple(map(plane, step.get("planes", ()))))
                    news = deadband.is_news(seq, proxy, step.get("probe", ()),
                                            1e-3 * step["at_ms"])
                    self.assertEqual(news, step["news"])
                    seq += news

    def test_without_a_width_all_are_news(self) -> None:
        deadband = Deadband((), 0.0, 1e-3, 1.0)
        for seq in range(1, 4):
            deadband.used(seq - 1)
            self.assertTrue(deadband.is_news(seq, Proxy(wire.PROXY_MODE_FREE), (), 0.0))


if __name__ == "__main__":
    unittest.main()
