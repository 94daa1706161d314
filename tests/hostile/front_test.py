"""Some attacks from inside the front, without times: for a host that does other things as well."""

import os
import tempfile
import unittest

import inside

NAMES = ("calls", "calls_landlock_0", "calls_user", "setown_landlock_0", "blocking_deaf", "clears",
         "sockets_shut", "dies_abort", "hangs")


class InsideTheFront(unittest.TestCase):
    def test_the_owner_holds(self):
        for mode in (mode for mode in inside.MODES if mode.name in NAMES):
            user = mode.more.get("user")
            if user is not None and os.geteuid() != 0:
                continue
            with self.subTest(mode.name), tempfile.TemporaryDirectory() as folder:
                os.chmod(folder, 0o755)
                wrong, _, log = inside.without_times(folder, mode, user)
                self.assertEqual(wrong, [], log[-2000:])


if __name__ == "__main__":
    unittest.main()
