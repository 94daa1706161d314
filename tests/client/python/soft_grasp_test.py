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


def slowly(*places: tuple[float, float]) -> soft_grasp.Grasp:
    """A finger that went from open through all of these, 0.01 rad per frame."""
    grasp, at = soft_grasp.Grasp(), (0.0, 0.0)
    for place in places:
        frames = math.ceil(math.dist(at, place) / 0.01)
        for i in range(1, frames + 1):
            grasp.step(tuple(a + i / frames * (p - a) for a, p in zip(at, place)), 0.05)
        at = place
    return grasp


def at_once(place: tuple[float, float]) -> soft_grasp.Grasp:
    grasp = soft_grasp.Grasp()
    grasp.step(place, 0.05)
    return grasp


def torque(q: tuple[float, ...]) -> tuple[float, float]:
    """Of the cylinder on the finger, N m, flexion positive, by forces and levers."""
    torque = [0.0, 0.0]
    pip = (soft_grasp.PROXIMAL_M * math.cos(q[0]), -soft_grasp.PROXIMAL_M * math.sin(q[0]))
    for i in range(1, soft_grasp.POINTS + 1):
        for base, length, angle, joints in (
                ((0.0, 0.0), soft_grasp.PROXIMAL_M, q[0], [(0.0, 0.0)]),
                (pip, soft_grasp.DISTAL_M, q[0] + q[1], [(0.0, 0.0), pip])):
            along = length * i / soft_grasp.POINTS
            point = (base[0] + along * math.cos(angle), base[1] - along * math.sin(angle))
            dx, dy = point[0] - soft_grasp.CENTRE[0], point[1] - soft_grasp.CENTRE[1]
            distance = math.hypot(dx, dy)
            force = soft_grasp.POINT_N_PER_M * max(0.0, soft_grasp.RADIUS_M - distance)
            fx, fy = force * dx / distance, force * dy / distance
            for j, (jx, jy) in enumerate(joints):
                torque[j] -= (point[0] - jx) * fy - (point[1] - jy) * fx
    return torque[0], torque[1]


class SoftGrasp(unittest.TestCase):
    def test_the_poses_are_what_they_say(self) -> None:
        self.assertTrue(soft_grasp.touching(CLOSED))
        self.assertFalse(soft_grasp.touching(BEHIND))
        self.assertFalse(soft_grasp.touching((0.0, 0.0)))

    def test_the_proxy_is_in_balance(self) -> None:
        x = slowly(CLOSED).x
        self.assertGreater(math.dist(x, CLOSED), 0.005)
        for a, p, t in zip(x, CLOSED, torque(x)):
            self.assertAlmostEqual(soft_grasp.JOINT_NM_PER_RAD * (p - a), -t, delta=1e-6)

    def test_joining_inside_is_as_coming_from_outside(self) -> None:
        for a, b in zip(at_once(CLOSED).x, slowly(CLOSED).x):
            self.assertAlmostEqual(a, b, delta=0.02)

    def test_a_finger_pushed_through_is_held_in_front(self) -> None:
        for grasp in (at_once(BEHIND), slowly(BEHIND)):
            self.assertTrue(soft_grasp.touching(grasp.x))
            self.assertLess(grasp.x[0], CLOSED[0])

    def test_a_finger_that_comes_back_is_free(self) -> None:
        self.assertEqual(slowly(BEHIND, (0.0, 0.0)).x, (0.0, 0.0))

    def test_what_is_near_is_told(self) -> None:
        near = soft_grasp.Grasp().step((0.2, 0.1), 0.03)
        self.assertEqual(near.mode, haptic.behind([], ()).mode)
        self.assertEqual({plane.compliance for plane in near.planes}, {0.05 / 400.0})
        self.assertEqual(soft_grasp.Grasp().step((0.0, 0.0), 0.0), haptic.FREE)


if __name__ == "__main__":
    unittest.main()
