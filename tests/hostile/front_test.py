"""Some attacks from inside the front, without times: for a host that does other things as well."""

import os
import pathlib
import tempfile
import unittest

import inside

NAMES = ("calls", "calls_landlock_0", "calls_user", "setown_landlock_0", "blocking_deaf", "clears",
         "sockets_shut", "dies_abort", "hangs", "threads", "reaches")


def all_users_reach(path: str) -> bool:
    file = pathlib.Path(path).resolve()
    return all(each.stat().st_mode & 0o001 for each in (file, *file.parents))


class InsideTheFront(unittest.TestCase):
    def test_the_owner_holds(self):
        for mode in (mode for mode in inside.MODES if mode.name in NAMES):
            user = mode.more.get("user")
            if user is not None and os.geteuid() != 0:
                continue
            if user is not None and not all_users_reach(os.environ["HAPTICD"]):
                print(f"{mode.name}: not run: user {user} may not reach {os.environ['HAPTICD']}")
                continue
            with self.subTest(mode.name), tempfile.TemporaryDirectory() as folder:
                os.chmod(folder, 0o755)
                wrong, _, log = inside.without_times(folder, mode, user)
                self.assertEqual(wrong, [], log[-2000:])


if __name__ == "__main__":
    unittest.main()
