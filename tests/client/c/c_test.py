"""libhaptic from outside: its header in every language that reads it, its symbols, a C program, and
Python's ctypes. $HAPTIC_C_LIBRARY, $HAPTIC_C_PROGRAMS (a folder) and $HAPTIC_C_HEADERS say where
they are."""

import ctypes
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "python"))
from hapticd_process import OneServer  # noqa: E402

HEADERS = pathlib.Path(os.environ["HAPTIC_C_HEADERS"])
LIBRARY = os.environ["HAPTIC_C_LIBRARY"]


def functions_of_header() -> set[str]:
    header = (HEADERS / "haptic/haptic.h").read_text()
    return set(re.findall(r"HAPTIC_API [^#(]*?(haptic_\w+)\(", header))


class Header(unittest.TestCase):
    def compiles(self, compiler: str, *options: str, suffix: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / ("source" + suffix)
            source.write_text("#include <haptic/haptic.h>\n#include <haptic/haptic.h>\n"
                              "int used(void) { return (int)sizeof(haptic_state); }\n")
            subprocess.run([compiler, *options, "-pedantic", "-Wall", "-Wextra", "-Werror",
                            "-Wconversion", f"-I{HEADERS}", "-c", source,
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
            names = re.findall(r"typedef struct (\w+) \{\s+size_t size;",
                               (HEADERS / "haptic/haptic_types.h").read_text())
            source.write_text("#include <haptic/haptic.h>\n#include <stdio.h>\nint main(void) {" +
                              "".join(f'printf("{name} %u\\n", (unsigned)sizeof({name}));'
                                      for name in names) + "return 0; }\n")
            program = source.with_suffix("")
            subprocess.run(["cc", "-std=c99", "-pedantic", "-Werror", f"-I{HEADERS}", source,
                            "-o", program], check=True)
            said = subprocess.run([program], capture_output=True, text=True, check=True).stdout
        sizes = {line.split()[0]: int(line.split()[1]) for line in said.splitlines()}
        self.assertEqual(sizes, {"haptic_connect_options": 56, "haptic_device": 9144,
                                 "haptic_error": 592, "haptic_event": 352, "haptic_plane": 1016,
                                 "haptic_session_options": 72, "haptic_settings": 824,
                                 "haptic_state": 3080, "haptic_statistics": 344})
        self.assertEqual(sizes["haptic_state"], ctypes.sizeof(State))


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


class FromC(OneServer):
    lease_s = 60  # the programs publish nothing for a while

    def run_program(self, name: str, *arguments: str) -> str:
        program = os.path.join(os.environ["HAPTIC_C_PROGRAMS"], name)
        done = subprocess.run([program, self.server.address, *arguments], capture_output=True,
                              text=True, timeout=120, check=False,
                              env={**os.environ, "MALLOC_PERTURB_": "165"})  # fills what is freed
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_all_of_the_header(self) -> None:
        self.run_program("haptic_c_session_test")

    def test_example_makes_force(self) -> None:
        """The finger rests at 0.52 rad, so it is beyond the wall of the example."""
        said = self.run_program("haptic-example-c-virtual-wall", "2")
        force = re.fullmatch(r"state 5, force (-?[\d.]+)\n", said)
        self.assertIsNotNone(force, said)
        assert force is not None
        self.assertGreater(abs(float(force[1])), 0.05)


class Dofs(ctypes.Structure):
    _fields_ = [("count", ctypes.c_uint32), ("value", ctypes.c_double * 24)]


class Coordinates(ctypes.Structure):
    _fields_ = [("count", ctypes.c_uint32), ("value", ctypes.c_double * 72)]


class Error(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("code", ctypes.c_int32),
                ("server_reason", ctypes.c_char * 64), ("message", ctypes.c_char * 512)]


class ConnectOptions(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("address", ctypes.c_char_p), ("tls", ctypes.c_int32),
                *((name, ctypes.c_char_p) for name in ("ca", "certificate", "key", "server"))]


class SessionOptions(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("device", ctypes.c_char_p),
                ("client_name", ctypes.c_char_p), ("observer", ctypes.c_int32),
                ("priority", ctypes.c_int32), ("nominal_rate_hz", ctypes.c_double),
                ("state_rate_hz", ctypes.c_double),
                *((name, ctypes.c_int32) for name in ("stream_only", "reconnect", "re_engage",
                                                      "derive_planes")),
                ("timeout_ms", ctypes.c_uint32)]


class State(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("seq", ctypes.c_uint64),
                ("server_time_ns", ctypes.c_int64), ("proxy_seq_used", ctypes.c_uint64),
                ("proxy_age_us", ctypes.c_uint64),
                *((name, ctypes.c_int32) for name in ("state", "mode", "staleness", "carrier")),
                *((name, ctypes.c_uint32) for name in ("lease_epoch", "faults", "limiters",
                                                       "active_planes")),
                ("gain", ctypes.c_double), ("q", Dofs), ("q_dot", Dofs), ("x_probe", Coordinates),
                ("x", Coordinates),
                *((name, Dofs) for name in ("q_star", "tau_a", "tau_elastic", "error_bound",
                                            "stiffness_in_effect", "tau_measured",
                                            "temperature_c")),
                ("projection", ctypes.c_int32), ("derating", ctypes.c_int32),
                ("derating_delay_us", ctypes.c_uint64), ("condition", ctypes.c_double),
                ("unexplained", ctypes.c_double)]


class FromCtypes(OneServer):
    """A foreign language that knows the header alone."""

    def setUp(self) -> None:
        super().setUp()
        self.library = ctypes.CDLL(LIBRARY)
        self.error = Error(size=ctypes.sizeof(Error))

    def call(self, name: str, *arguments: object) -> None:
        code = getattr(self.library, name)(*arguments, ctypes.byref(self.error))
        self.assertEqual(code, 0, self.error.message)

    def test_holds_a_proxy(self) -> None:
        connection, session = ctypes.c_void_p(), ctypes.c_void_p()
        server = ConnectOptions(size=ctypes.sizeof(ConnectOptions),
                                address=self.server.address.encode())
        self.call("haptic_connect", ctypes.byref(server), ctypes.byref(connection))
        options = SessionOptions(size=ctypes.sizeof(SessionOptions), client_name=b"ctypes",
                                 nominal_rate_hz=100, state_rate_hz=100)
        self.call("haptic_open", connection, ctypes.byref(options), ctypes.byref(session))
        self.call("haptic_engage_when_ready", session)
        state = State(size=ctypes.sizeof(State))
        for _ in range(2000):
            self.call("haptic_wait_for_state", session, 10000, ctypes.byref(state))
            if state.state == 5 and abs(state.tau_a.value[0]) > 0.1:
                break
            if state.gain == 0:
                self.call("haptic_publish_free", session)
                continue
            x = (ctypes.c_double * 2)(state.x_probe.value[0] + 0.01, state.x_probe.value[1])
            self.call("haptic_publish_held", session, x, ctypes.c_size_t(2))
        self.assertEqual((state.state, state.x.count, state.q.count), (5, 2, 2))
        self.assertEqual(self.library.haptic_close(session), 0)
        self.assertEqual(self.library.haptic_close(session), -8)
        self.assertEqual(self.library.haptic_disconnect(connection), 0)


if __name__ == "__main__":
    unittest.main()
