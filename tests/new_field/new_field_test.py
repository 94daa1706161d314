"""Fields that only a test declares: the program of new_field_test.cpp, then its state and a contact
in C#, JavaScript and Python, as far as they were built."""

import os
import pathlib
import subprocess
import sys
import unittest

MESSAGE, STRUCT = (pathlib.Path(os.environ["HAPTIC_STATE_BYTES"] + end)
                   for end in (".message", ".struct"))
# The package's own module of this name loads the library; the messages need only this of it.
LIBRARY = """
def lists(array, count):
    return tuple(array[i] for i in range(count))

def name_of(names, number):
    return names.get(number, str(number))

def floats(values):
    return tuple(map(float, values))

def put(array, values, name):
    return len(values)
"""


def said(*command: str) -> list[str]:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()


class NewField(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        for old in (MESSAGE, STRUCT):
            old.unlink(missing_ok=True)
        subprocess.run([os.environ["HAPTIC_NEW_FIELD"]], check=True)

    @unittest.skipUnless("HAPTIC_NEW_FIELD_CSHARP" in os.environ, "mono is not here")
    def test_is_a_member_in_csharp(self) -> None:
        self.assertEqual(said(os.environ["HAPTIC_MONO"], os.environ["HAPTIC_NEW_FIELD_CSHARP"],
                              str(MESSAGE)), ["0.625", "-1.5", "C1-3E-00-00-00-00-00-00-F8-3F"],
                         "number 1000 as a double, then 1.5")

    @unittest.skipUnless("HAPTIC_NEW_FIELD_JS" in os.environ, "npm is not here")
    def test_is_a_member_and_a_row_in_javascript(self) -> None:
        self.assertEqual(said(os.environ["HAPTIC_NODE"], os.environ["HAPTIC_NEW_FIELD_JS"],
                              str(MESSAGE)), ["0.625", "-1.5", "0.625", "N", "-1.5", "N",
                                             "1.5"])

    def test_is_a_member_in_python(self) -> None:
        package = pathlib.Path(os.environ["HAPTIC_NEW_FIELD_PYTHON"], "haptic")
        (package / "__init__.py").write_text("")
        (package / "_library.py").write_text(LIBRARY)
        sys.path.insert(0, str(package.parent))
        from haptic._libhaptic import ffi
        from haptic._messages import DeviceState, Told
        state = DeviceState.of(ffi.from_buffer("haptic_state *", STRUCT.read_bytes()))
        self.assertEqual((state.tested, state.tested_list), (0.625, (-1.5,)))
        contact = ffi.new("haptic_contact *")
        Told(stickiness=3.0).tell(contact)
        self.assertEqual(contact.stickiness, 3.0)


unittest.main(verbosity=2)
