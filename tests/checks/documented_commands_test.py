"""The check of documented commands bites: on made-up documents and programs."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from documented_commands import PROGRAMS, check_options, check_table, commands  # noqa: E402

HELP = "#!/bin/sh\nif [ \"$1\" = watch ]; then echo --json; else echo --server; fi\n"


class Documents(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.programs = self.root / "build"
        for place in PROGRAMS.values():
            program = self.programs / place
            program.parent.mkdir(parents=True, exist_ok=True)
            program.write_text(HELP, encoding="utf-8")
            program.chmod(0o755)

    def page(self, text: str) -> None:
        (self.root / "README.md").write_text(text, encoding="utf-8")

    def test_options_of_the_help_are_right(self) -> None:
        self.page("Run `hapticctl --server a:1 watch --json`; prose -- with dashes.\n")
        self.assertEqual(check_options(self.root, self.programs), [])

    def test_an_option_that_is_not_there_is_named(self) -> None:
        self.page("Run `hapticctl watch --jsn`, or\n\n    hapticd --secne FILE\n")
        self.assertEqual(check_options(self.root, self.programs),
                         ["documents: `hapticctl watch` has no --jsn", "documents: `hapticd ` has no --secne"])

    def test_a_command_that_no_test_runs_is_named(self) -> None:
        self.page("```sh\nmake coffee && make tea   # both\n```\n")
        self.assertEqual(list(commands(self.root)), ["make coffee", "make tea"])
        with self.assertRaises(FileNotFoundError):  # the tree that the table speaks of is not here ...
            check_table(self.root)
        root = pathlib.Path(__file__).parents[2]
        self.assertEqual(check_table(root), [])  # ... but there


if __name__ == "__main__":
    unittest.main()
