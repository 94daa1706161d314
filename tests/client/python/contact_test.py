"""Contacts and proxies against the shared vectors of all languages (make_contacts.py), and what is
refused."""

import json
import math
import pathlib
import unittest
from collections.abc import Sequence
from typing import Any

import haptic

VECTORS = json.loads(pathlib.Path(__file__).parents[1].joinpath("contacts.json").read_text())
LAW = ("velocity", "id", "mass", "damping", "ground_stiffness", "load", "uncertainty")


def point_of(tool: dict[str, Any], x: Sequence[float]) -> haptic.PointMap:
    first = tool["first"]
    if tool["kind"] == "itself":
        return haptic.point_itself(x, first)
    if tool["kind"] == "pose":
        return haptic.point_on_pose(x, tool["offset"], first)
    if tool["kind"] == "joints":
        joints = [haptic.JointAxis(**joint) for joint in tool["joints"]]
        return haptic.point_on_joints(joints, tool["point"], first)
    return haptic.point_on_finger(tool["lengths"], x, tool["phalanx"], tool["along"],
                                  tool["palmar"], first)


def contact_of(told: dict[str, Any], x: Sequence[float]) -> haptic.Contact:
    object_, point = told["object"], point_of(told["tool"], x)
    shape, axis, radius = object_["shape"], object_["axis"], object_["radius"]
    away = [p - c for p, c in zip(point.position, object_["centre"])]
    along = sum(a * b for a, b in zip(away, axis))
    if shape == "rod":
        away = [a - along * b for a, b in zip(away, axis)]
    distance = math.copysign(math.hypot(*away), radius)
    normal = axis if shape == "wall" else [a / distance for a in away]
    curvature = {"wall": lambda: (0.0,) * 6,
                 "ball": lambda: haptic.sphere_curvature(normal, distance),
                 "rod": lambda: haptic.cylinder_curvature(normal, axis, distance)}[shape]()
    stiffness = math.inf if told["stiffness"] == "rigid" else told["stiffness"]
    return haptic.Contact(point, normal, along if shape == "wall" else distance - radius, stiffness,
                          curvature, object=told["on"], object_direction=told["direction"],
                          **{name: told[name] for name in LAW})


class Shared(unittest.TestCase):
    def near(self, actual: Sequence[float], expected: Sequence[float], within: float) -> None:
        self.assertEqual(len(actual), len(expected))
        for a, b in zip(actual, expected):
            self.assertAlmostEqual(a, b, delta=within)

    def test_planes_are_the_shared_ones(self) -> None:
        within = {"curvature": 1e-13}
        for row in VECTORS["planes"]:
            plane = haptic.contact_at(row["x"], contact_of(row["contact"], row["x"]),
                                      row["coupling"])
            for name, value in row["plane"].items():
                with self.subTest(name, contact=row["contact"]):
                    told = getattr(plane, name)
                    if value is None:
                        self.assertIsNone(told)
                    elif isinstance(value, list):
                        self.near(told, value, within.get(name, 1e-15))
                    else:
                        self.assertAlmostEqual(told, value, delta=1e-15)

    def test_proxies_are_the_shared_ones(self) -> None:
        for row in VECTORS["solve"]:
            with self.subTest(row["name"]):
                found = haptic.solve(lambda x: [contact_of(told, x) for told in row["contacts"]],
                                     row["x_probe"], row["coupling"], start=row["start"],
                                     weights=row["weights"])
                self.assertTrue(found.converged)
                self.near(found.x, row["x"], 1e-10)

    def test_horizons_are_the_shared_ones(self) -> None:
        for row in VECTORS["horizon"]:
            told = haptic.contact_horizon(row["round_trip_s"], row["period_s"], row["v_max"])
            self.assertAlmostEqual(told, row["metres"], delta=1e-15)


class Refused(unittest.TestCase):
    def test_coordinates_beyond_x_are_refused(self) -> None:
        for point, words in (
                (haptic.point_itself((0.0,) * 4, 1), "first_coordinate = 1: the point has 3 "
                 "coordinates, must lie within the 3 of x"),
                (haptic.PointMap(0, (0.0,) * 3, [(1.0, 0.0, 0.0)], [(0.0,) * 3] * 2),
                 "point: has 1 coordinates, must have at most 8; second: has 2 vectors, must have "
                 "0 or 1")):
            with self.assertRaises(ValueError) as raised:
                haptic.contact_at((0.0,) * 3, haptic.Contact(point, (1.0, 0.0, 0.0), 0.0), 1.0)
            self.assertEqual(str(raised.exception), words)


class Solve(unittest.TestCase):
    """A spring of 300 N/m that begins at x[0] = 0.1, as `n` equal ones."""

    @staticmethod
    def springs(x: tuple[float, ...], n: int = 1) -> list[haptic.Contact]:
        point = haptic.point_itself(x)
        return [haptic.Contact(point, (-1.0, 0.0, 0.0), 0.1 - x[0], 300.0 / n, id=i + 1)
                for i in range(n)]

    def test_the_proxy_is_in_balance(self) -> None:
        for n in (1, 100):  # more than there is room for at first
            found = haptic.solve(lambda x: self.springs(x, n), (0.5, 0.2, 0.0), 100.0,
                                 start=(0.0, 0.2, 0.0))
            self.assertTrue(found.converged)
            self.assertAlmostEqual(found.x[0], 0.2, delta=1e-9)  # 100 (x - 0.5) + 300 (x - 0.1) = 0
            self.assertEqual(found.x[1:], (0.2, 0.0))
            self.assertEqual([plane.id for plane in found.planes], list(range(1, n + 1)))
            self.assertEqual(found.proxy(), haptic.behind(found.planes, found.x))

    def test_nothing_touched_is_free(self) -> None:
        found = haptic.solve(lambda x: [], (0.5, 0.2, 0.0), 100.0)
        self.assertEqual((found.x, found.proxy()), ((0.5, 0.2, 0.0), haptic.FREE))

    def test_what_the_contacts_raise_comes_through(self) -> None:
        def fails(x: tuple[float, ...]) -> list[haptic.Contact]:
            raise KeyError("my object")

        with self.assertRaisesRegex(KeyError, "my object"):
            haptic.solve(fails, (0.5, 0.2, 0.0), 100.0)
        with self.assertRaisesRegex(ValueError, "coupling: -1"):
            haptic.solve(self.springs, (0.5, 0.2, 0.0), -1.0)
        with self.assertRaisesRegex(ValueError, "weights: has 1 values, must have 3"):
            haptic.solve(self.springs, (0.5, 0.2, 0.0), 1.0, weights=(1.0,))


class DerivePlanes(unittest.TestCase):
    def test_one_plane_per_held_block(self) -> None:
        coordinates = [haptic.Coordinate(name, "m", "linear") for name in "abc"]
        plane, = haptic.derive_planes(coordinates, (1.0, 2.0, 3.0), (1.0, 2.5, 3.0),
                                      [(0, 1), (1, 2)])
        self.assertEqual((plane.normal[0], plane.normal[2]), (0.0, 0.0))
        self.assertAlmostEqual(plane.offset / plane.normal[1], 2.0)  # through x
        self.assertGreater(plane.normal[1], 0.0)  # the probe is beyond it
        self.assertEqual(haptic.derive_planes([], (), ()), [])


if __name__ == "__main__":
    unittest.main()
