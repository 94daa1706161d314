"""The package as a binding: how it finds its library, that it leaves nothing of the C header out,
and that it takes any sequence of numbers."""

from __future__ import annotations

import os
import pathlib
import pydoc
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from collections.abc import Iterator

import haptic
from haptic._library import ffi

HEADERS = [pathlib.Path(place) for place in os.environ["HAPTIC_C_HEADERS"].split(":")]
PACKAGE = pathlib.Path(haptic.__file__).parent


class Imports(unittest.TestCase):
    """Copies of the package, beside a library of the test's own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copytree(PACKAGE, self.folder / "python/haptic")
        (self.folder / "c").mkdir()
        self.library = self.folder / "c/libhaptic.so.0"

    def refused(self, script: str = "") -> str:
        """What the import says."""
        run = subprocess.run([sys.executable, "-c", script + "import haptic"], text=True,
                             capture_output=True, timeout=60,
                             env={**os.environ, "PYTHONPATH": str(self.folder / "python")})
        self.assertIn("\nImportError: ", run.stderr)
        self.assertNotIn("During handling", run.stderr)
        return run.stderr.splitlines()[-1]

    def test_without_the_library_it_names_the_package(self) -> None:
        self.library.write_text("no library")
        self.assertRegex(self.refused(), rf"install the package libhaptic0 {haptic.__version__} \(")

    def test_another_version_is_refused_with_both(self) -> None:
        self.library.symlink_to(os.environ["HAPTIC_C_LIBRARY"])
        (self.folder / "python/haptic/_version.py").write_text('__version__ = "7.8.9"\n')
        self.assertRegex(self.refused(), rf"haptic 7.8.9 needs .*is {haptic.__version__}: install")

    def test_without_cffi_it_names_the_package(self) -> None:
        self.assertIn("install the package python3-cffi-backend",
                      self.refused("import sys; sys.modules['_cffi_backend'] = None; "))


class Header(unittest.TestCase):
    def test_structs_are_as_the_compiler_lays_them_out(self) -> None:
        structs = sorted(name for name in ffi.list_types()[0]
                         if ffi.typeof(name).kind == "struct" and ffi.typeof(name).fields)
        self.assertGreater(len(structs), 15)
        ends = [(name, ffi.typeof(name).fields[-1][0]) for name in structs]
        with tempfile.TemporaryDirectory() as folder:
            program = os.path.join(folder, "layout")
            lines = "".join(f'printf("%zu %zu\\n", sizeof({name}), offsetof({name}, {end}));'
                            for name, end in ends)
            subprocess.run(["cc", "-std=c99", *(f"-I{place}" for place in HEADERS), "-xc", "-",
                            "-o", program], text=True, check=True,
                           input="#include <haptic/haptic.h>\n#include <stdio.h>\n"
                           f"int main(void) {{ {lines} return 0; }}\n")
            said = subprocess.run([program], check=True, capture_output=True, text=True).stdout
        self.assertEqual([tuple(map(int, line.split())) for line in said.splitlines()],
                         [(ffi.sizeof(name), ffi.offsetof(name, end)) for name, end in ends])

    def test_every_function_has_its_counterpart(self) -> None:
        declared = set(re.findall(r"HAPTIC_API [^#(]*?(haptic_\w+)\(",
                                  (HEADERS[0] / "haptic/haptic.h").read_text()))
        used = set(re.findall(r"lib(?:rary)?\.(haptic_\w+)", "".join(
            module.read_text() for module in PACKAGE.glob("*.py"))))
        # haptic_publish() is all of these.
        self.assertEqual(declared - used, {"haptic_publish_free", "haptic_publish_held",
                                           "haptic_publish_planes"})
        self.assertEqual(used - declared, set())


class Help(unittest.TestCase):
    def test_it_has_less_than_300_lines(self) -> None:
        lines = pydoc.plain(pydoc.render_doc(haptic)).splitlines()
        self.assertLess(len(lines), 300)
        self.assertTrue(any("engage_when_ready" in line for line in lines))


class Array:
    """Behaves as numpy's: comparing gives an array, whose truth is ambiguous."""

    def __init__(self, *values: float) -> None:
        self.values = values

    def __iter__(self) -> Iterator[float]:
        return iter(self.values)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, i: int) -> float:
        return self.values[i]

    def __eq__(self, other: object) -> Array:  # type: ignore[override]
        return self

    def __bool__(self) -> bool:
        raise ValueError("the truth value of an array is ambiguous")


class Arrays(unittest.TestCase):
    """Beside those of session_test.py, which go to a server."""

    def test_they_are_taken_everywhere(self) -> None:
        x, up = Array(0.1, 0.2, 0.3), Array(0.0, 0.0, 1.0)
        self.assertEqual(haptic.held(x).position, (0.1, 0.2, 0.3))
        wall = haptic.behind([(up, 0.3), haptic.Plane(up, 0.4, curvature=Array(1.0))], x)
        self.assertEqual([plane.normal for plane in wall.planes], [(0.0, 0.0, 1.0)] * 2)
        self.assertEqual(wall.planes[1].curvature, (1.0,))
        self.assertEqual(haptic.contact(x, 0.1, up, curvature=Array()).normal[2], -1.0)
        hinge = haptic.JointAxis(Array(0.0, 0.0, 0.0), up)
        for point in (haptic.point_itself(x), haptic.point_on_joints([hinge], x),
                      haptic.point_on_finger(Array(0.04), x, 1, 0.02),
                      haptic.point_on_pose(Array(0, 0, 0, 0, 0, 0, 1), x),
                      haptic.PointMap(0, x, [up], Array())):
            told = haptic.Contact(point, up, 0.1, 400.0, haptic.sphere_curvature(up, 0.3), id=1,
                                  object_direction=Array())
            place = Array(*(0.1 for _ in range(7)))
            self.assertEqual(haptic.contact_at(place, told, 0.02).id, 1)
        haptic.cylinder_curvature(up, Array(1.0, 0.0, 0.0), 0.3)
        found = haptic.solve(lambda _: [], x, 1.0, start=x, weights=Array(1.0, 2.0, 3.0))
        self.assertEqual(found.x, (0.1, 0.2, 0.3))
        coordinates = [haptic.Coordinate(name, "m", "linear") for name in "abc"]
        self.assertEqual(len(haptic.derive_planes(coordinates, x, up, [Array(0, 3)])), 1)

    def test_wrong_numbers_of_values_are_named(self) -> None:
        x = (0.0, 0.0, 0.0)
        point, soft = haptic.point_itself(x), {"gap": 0.1, "stiffness": 400.0}
        for call, words in (
                (lambda: haptic.Plane(Array(1.0), 0.0, curvature=Array(*range(37))).fill(
                    haptic._library.new("haptic_plane")), "curvature: has 37 values, must have"),
                (lambda: haptic.point_on_pose(Array(*range(7)), Array(1.0)),
                 "offset: has 1 values, must have 3"),
                (lambda: haptic.contact_at(x, haptic.Contact(point, (1, 0), **soft), 1.0),
                 "normal: has 2 values, must have 3"),
                (lambda: haptic.contact_at(x, haptic.Contact(point, (1, 0, 0), 0.1, 0.0), 1.0),
                 "stiffness: 0, must be > 0"),
                (lambda: haptic.point_on_joints([haptic.JointAxis(x, (0, 1))], x),
                 "axis: has 2 values, must have 3")):
            with self.assertRaisesRegex(ValueError, words):
                call()


if __name__ == "__main__":
    unittest.main()
