"""The proxy of the soft grasp: on the side of the cylinder that the finger came from."""

import math
import os
import sys
import unittest

import haptic

sys.path.insert(0, os.path.join(os.environ["HAPTIC_SCENES"], "../../client/python/examples"))
import soft_grasp  # noqa: E402

CLOSED = (0.75, 0.4)  # rad: in the cylinder
BEHIND = (1.7, 0.2)  # beyond it, touching nothing


def slowly(*places: tuple[float, float]) -> haptic.Proxy:
    """The proxy of a finger that went from open through all of these, 0.01 rad per frame."""
    grasp, at = soft_grasp.Grasp(), (0.0, 0.0)
    for place in places:
        frames = math.ceil(math.dist(at, place) / 0.01)
        for i in range(1, frames + 1):
            proxy = grasp.step(tuple(a + i / frames * (p - a) for a, p in zip(at, place)))
        at = place
    return proxy


class SoftGrasp(unittest.TestCase):
    def test_the_poses_are_what_they_say(self) -> None:
        self.assertTrue(any(soft_grasp.contact_torque(CLOSED)))
        self.assertFalse(any(soft_grasp.contact_torque(BEHIND)))
        self.assertFalse(any(soft_grasp.contact_torque((0.0, 0.0))))

    def test_joining_inside_is_as_coming_from_outside(self) -> None:
        joined = soft_grasp.Grasp().step(CLOSED)
        came = slowly(CLOSED)
        self.assertEqual(joined.mode, came.mode)
        self.assertNotEqual(joined, haptic.FREE)
        for a, b in zip(joined.position, came.position):
            self.assertAlmostEqual(a, b, delta=0.02)

    def test_a_finger_pushed_through_is_held_in_front(self) -> None:
        for proxy in (soft_grasp.Grasp().step(BEHIND), slowly(BEHIND)):
            self.assertNotEqual(proxy, haptic.FREE)
            self.assertLess(proxy.position[0], CLOSED[0])

    def test_a_finger_that_comes_back_is_free(self) -> None:
        self.assertEqual(slowly(BEHIND, (0.0, 0.0)), haptic.FREE)


if __name__ == "__main__":
    unittest.main()
