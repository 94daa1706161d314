"""Contacts from a simulation's geometry, against differences of the gap itself."""

import math
import unittest
from collections.abc import Callable

import haptic
from haptic._sample import deepest, difference

RADIUS, CENTRE = 0.02, (0.06, 0.01, 0.02)
Point = Callable[[list[float]], haptic.PointMap]


def slide_and_hinge(x: list[float]) -> haptic.PointMap:
    """A slide along (0.6, 0.8, 0), and a hinge about z on it."""
    hinge = (0.6 * x[1], 0.8 * x[1], 0.0)
    point = (hinge[0] + 0.03 * math.cos(x[2]), hinge[1] + 0.03 * math.sin(x[2]), 0.01)
    return haptic.point_on_joints([haptic.JointAxis((0, 0, 0), (0.6, 0.8, 0.0), True),
                                   haptic.JointAxis(hinge, (0.0, 0.0, 1.0))], point, 1)


CASES: dict[str, tuple[Point, list[float]]] = {
    "joints": (slide_and_hinge, [9.0, 0.02, 0.4]),
    "finger": (lambda x: haptic.point_on_finger((0.045, 0.03), x, 1, 0.02, 0.008, 1),
               [9.0, 0.4, 0.8]),
    "point": (lambda x: haptic.point_itself(x, 1), [9.0, 0.01, 0.02, 0.03]),
    "pose": (lambda x: haptic.point_on_pose(x, (0.03, -0.02, 0.05), 1),
             [9.0, 0.01, 0.02, 0.03, 0.1, -0.2, 0.3, math.sqrt(0.86)]),
}


def contact(point: haptic.PointMap, x: list[float], rod: bool) -> tuple[float, haptic.Plane]:
    away = [p - c for p, c in zip(point.position, CENTRE)]
    if rod:
        away[2] = 0.0
    distance = math.hypot(*away)
    n = [a / distance for a in away]
    curvature = (haptic.cylinder_curvature(n, (0, 0, 1), distance) if rod else
                 haptic.sphere_curvature(n, distance))
    return distance - RADIUS, haptic.contact_at(
        x, point, n, distance - RADIUS, coupling=0.02, stiffness=400.0, curvature=curvature, id=7,
        mass=0.2, damping=3.0, ground_stiffness=50.0, load=-1.0, object=3 if rod else 0)


def moved(x: list[float], *by: tuple[int, float]) -> list[float]:
    x = list(x)
    for i, step in by:
        x[i] += step
    return x


class ContactAt(unittest.TestCase):
    def test_it_is_the_gap_to_second_order(self) -> None:
        h = 1e-4
        for name, (point, x) in CASES.items():
            for rod in (False, True):
                def gap(y: list[float]) -> float:
                    return contact(point(y), y, rod)[0]

                plane, n = contact(point(x), x, rod)[1], len(point(x).jacobian)
                with self.subTest(name, rod=rod):
                    told = plane.offset - sum(a * b for a, b in zip(plane.normal, x))
                    self.assertAlmostEqual(told, gap(x), delta=1e-15)
                    self.assertEqual(plane.compliance, 5e-5)
                    self.assertEqual((plane.mass, plane.damping), (10.0, 150.0))
                    self.assertEqual((plane.ground_stiffness, plane.load), (2500.0, -50.0))
                    self.assertEqual((plane.object, len(plane.object_direction)),
                                     (3, 3) if rod else (0, 0))
                    self.assertEqual((plane.first_coordinate, plane.normal[0], plane.id),
                                     (1, 0.0, 7))
                    k = 0
                    for i in range(1, n + 1):
                        slope = (gap(moved(x, (i, h))) - gap(moved(x, (i, -h)))) / (2 * h)
                        self.assertAlmostEqual(-plane.normal[i], slope, delta=1e-6)
                        for j in range(1, i + 1):
                            second = sum(a * b * gap(moved(x, (i, a * h), (j, b * h)))
                                         for a in (1, -1) for b in (1, -1)) / (4 * h * h)
                            self.assertAlmostEqual(plane.curvature[k], second, delta=1e-3)
                            k += 1

    def test_coordinates_beyond_x_are_refused(self) -> None:
        for point, words in (
                (haptic.point_itself((0.0,) * 4, 1), "point.first_coordinate 1, 3 coordinates: "
                 "must lie within the 3 of position"),
                (haptic.PointMap(0, (0.0,) * 3, [(1.0, 0.0, 0.0)], [(0.0,) * 3] * 2),
                 "point.second: has 2 vectors, must have 0 or 1 for 1 coordinates")):
            with self.assertRaises(ValueError) as raised:
                haptic.contact_at((0.0,) * 3, point, (1.0, 0.0, 0.0), 0.0, coupling=1.0)
            self.assertEqual(str(raised.exception), words)

    def test_the_horizon_is_how_far_a_point_gets(self) -> None:
        self.assertAlmostEqual(haptic.contact_horizon(0.1, 0.02, 0.3), 0.036)
        self.assertAlmostEqual(haptic.contact_horizon(0.0, 0.0, 0.5), 0.1)


class Deepest(unittest.TestCase):
    def test_eight_contacts_of_a_block(self) -> None:
        planes = [haptic.Plane((1.0, 0.0), float(i), id=i + 1) for i in range(12)]
        planes.append(haptic.Plane((0.0, 1.0), 99.0, id=99))
        kept = deepest(planes, (0.0, 0.0), (), ("linear",) * 2)
        self.assertEqual([plane.id for plane in kept], [*range(1, 9), 99])

    def test_curvature_without_room_becomes_flat(self) -> None:
        planes = [haptic.Plane(tuple(float(i == j) for j in range(28)), 27.0 - i,
                               curvature=(1.0,) * 28) for i in range(28)]
        kept = deepest(planes, (0.0,) * 28, (), ("linear",) * 28)
        self.assertEqual([bool(plane.curvature) for plane in kept], [False] * 17 + [True] * 11)

    def test_angles_go_the_short_way_round(self) -> None:
        planes = [haptic.Plane((1.0,), 3.2 + 0.01 * i) for i in range(33)]
        planes[0] = haptic.Plane((-1.0,), 3.0)
        self.assertEqual(deepest(planes, (3.1,), (-3.1,), ("angle",)), planes[1:])
        self.assertAlmostEqual(difference(("angle",), (-3.1,), (3.1,))[0], math.tau - 6.2)
        pose = ("linear",) + ("quaternion",) * 4
        self.assertEqual(difference(pose, (1.0, 0.0, -0.6, 0.0, -0.8), (0.0, 0.0, 0.0, 0.0, 1.0)),
                         [1.0, 0.0, 0.6, 0.0, 0.8 - 1.0])

    def test_what_is_no_number_is_farthest(self) -> None:
        planes = [haptic.Plane((1.0,), math.nan if i % 2 else float(i)) for i in range(64)]
        self.assertEqual(deepest(planes, (0.0,), (), ("linear",)), planes[::2])


if __name__ == "__main__":
    unittest.main()
