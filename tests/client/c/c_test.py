"""libhaptic from outside: its header in C and C++, its symbols, and programs in C. Python reads the
header as well: python.*. $HAPTIC_C_LIBRARY, $HAPTIC_C_PROGRAMS (a folder) and $HAPTIC_C_HEADERS
(folders) say where they are."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "python"))
from hapticd_process import Hapticd  # noqa: E402

HEADERS = [pathlib.Path(each) for each in os.environ["HAPTIC_C_HEADERS"].split(":")]
INCLUDE = [f"-I{each}" for each in HEADERS]
LIBRARY = os.environ["HAPTIC_C_LIBRARY"]


def functions_of_header() -> set[str]:
    header = (HEADERS[0] / "haptic/haptic.h").read_text()
    return set(re.findall(r"HAPTIC_API [^#(]*?(haptic_\w+)\(", header))


class Header(unittest.TestCase):
    def compiles(self, compiler: str, *options: str, suffix: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / ("source" + suffix)
            source.write_text("#include <haptic/haptic.h>\n#include <haptic/haptic.h>\n"
                              "int used(void) { return (int)sizeof(haptic_state); }\n")
            subprocess.run([compiler, *options, "-pedantic", "-Wall", "-Wextra", "-Werror",
                            "-Wconversion", *INCLUDE, "-c", source,
                            "-o", source.with_suffix(".o")], check=True)

    def test_compiles_as_c99(self) -> None:
        self.compiles("cc", "-std=c99", suffix=".c")

    def test_compiles_as_cpp(self) -> None:
        self.compiles("c++", "-std=c++11", suffix=".cpp")

    def test_sizes_are_those_of_release_0(self) -> None:
        """A struct that has grown is longer than here; then structs.hpp needs this as kFirstSize.
        What became shorter breaks programs."""
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "sizes.c"
            names = re.findall(r"typedef struct (\w+) \{\s+size_t size;", "".join(
                header.read_text() for each in HEADERS for header in each.glob("haptic/*.h")))
            source.write_text("#include <haptic/haptic.h>\n#include <stdio.h>\nint main(void) {" +
                              "".join(f'printf("{name} %u\\n", (unsigned)sizeof({name}));'
                                      for name in names) + "return 0; }\n")
            program = source.with_suffix("")
            subprocess.run(["cc", "-std=c99", "-pedantic", "-Werror", *INCLUDE, source,
                            "-o", program], check=True)
            said = subprocess.run([program], capture_output=True, text=True, check=True).stdout
        sizes = {line.split()[0]: int(line.split()[1]) for line in said.splitlines()}
        self.assertGreaterEqual(sizes.pop("haptic_state"), 3680)  # it grows with the protocol
        self.assertEqual(sizes, {
            "haptic_connect_options": 56, "haptic_contact": 1320, "haptic_device": 19472,
            "haptic_error": 592, "haptic_event": 352, "haptic_plane": 1016, "haptic_point": 1104,
            "haptic_pose": 72, "haptic_proxy": 56, "haptic_server_info": 2000,
            "haptic_session_options": 112, "haptic_settings": 1336, "haptic_solution": 608,
            "haptic_solve_options": 40, "haptic_statistics": 376})


class Symbols(unittest.TestCase):
    def test_are_those_of_the_header(self) -> None:
        listed = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], check=True,
                                capture_output=True, text=True).stdout
        exported = {line.split()[2].split("@")[0] for line in listed.splitlines()}
        exported.discard("HAPTIC_0")  # the version's own name
        self.assertEqual(exported, functions_of_header())
        self.assertGreater(len(exported), 15)

    def test_so_name_is_that_of_the_abi(self) -> None:
        dynamic = subprocess.run(["readelf", "-d", LIBRARY], check=True, capture_output=True,
                                 text=True).stdout
        self.assertIn("[libhaptic.so.0]", dynamic)


class FromC(unittest.TestCase):
    def setUp(self) -> None:
        self.server = Hapticd("finger_constant", lease_s=60)  # the programs are silent for a while
        self.addCleanup(self.server.stop)

    def run_program(self, name: str, *arguments: str) -> str:
        program = os.path.join(os.environ["HAPTIC_C_PROGRAMS"], name)
        done = subprocess.run([program, self.server.address, *arguments], capture_output=True,
                              text=True, timeout=120, check=False,
                              env={**os.environ, "MALLOC_PERTURB_": "165"})  # fills what is freed
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_what_is_its_own(self) -> None:
        self.run_program("haptic_c_session_test")

    def test_example_makes_force(self) -> None:
        """The finger rests at 0.52 rad, so it is beyond the wall of the example."""
        said = self.run_program("haptic-example-c-virtual-wall", "2")
        force = re.fullmatch(r"state 5, force (-?[\d.]+)\n", said)
        self.assertIsNotNone(force, said)
        assert force is not None
        self.assertGreater(abs(float(force[1])), 0.05)


if __name__ == "__main__":
    unittest.main()
