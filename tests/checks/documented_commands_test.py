"""The positive control of documented_commands.py, on made-up documents and programs."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from documented_commands import (
    CODE,
    PROGRAMS,
    SCRIPTS,
    check_code,
    check_options,
    check_scripts,  # noqa: E402
    check_table,
    commands,
)

HELP = '#!/bin/sh\nif [ "$1" = watch ]; then echo --json; else echo --server; fi\n'


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
        self.assertEqual(
            check_options(self.root, self.programs),
            ["documents: `hapticctl watch` has no --jsn", "documents: `hapticd ` has no --secne"],
        )

    def test_a_scripts_words_are_those_of_its_usage(self) -> None:
        script = self.root / "tests/bench/run.sh"
        script.parent.mkdir(parents=True)
        script.write_text(
            "#!/bin/sh\n#   run.sh [core|loop]... [--out FILE]\n\n# wire\n: $SECONDS_EACH\n",
            encoding="utf-8",
        )
        script.chmod(0o755)
        known = {"tests/bench/run.sh": ("a test", "words")}
        self.page(
            "`tests/bench/run.sh`, `SECONDS_EACH=2 tests/bench/run.sh core|loop --out FILE.csv`\n"
        )
        self.assertEqual(check_scripts(self.root, known), [])
        self.page("`A=1 tests/bench/run.sh wire --put X -- --anything`, `server/demo.sh`\n")
        self.assertEqual(
            check_scripts(self.root, known),
            [
                "README.md: `tests/bench/run.sh` knows no A",
                "README.md: `tests/bench/run.sh` says nothing of wire",
                "README.md: `tests/bench/run.sh` says nothing of --put",
                "README.md: no test runs `server/demo.sh`",
                "README.md: `server/demo.sh` is not there, or no program",
            ],
        )
        self.page("nothing\n")
        self.assertEqual(
            check_scripts(self.root, known),
            ["documented_commands.py: no document names `tests/bench/run.sh`"],
        )

    def test_code_that_no_test_knows_is_named(self) -> None:
        self.page("```cpp\nint x;\n```\n```cpp\nint y;\n```\n")
        self.assertEqual(check_code(self.root, {}), ["README.md: 2 pieces of cpp, tested are 0"])
        (self.root / "a_test").write_text("pieces\n", encoding="utf-8")
        self.assertEqual(check_code(self.root, {("README.md", "cpp"): (2, "a_test", "pieces")}), [])
        self.assertEqual(
            check_code(self.root, {("README.md", "cpp"): (2, "a_test", "other")}),
            ["a_test does not test the cpp of README.md: no 'other' in it"],
        )
        self.page("```python\nif:\n```\n")
        with self.assertRaises(SyntaxError):
            check_code(self.root, {})

    def test_a_command_that_no_test_runs_is_named(self) -> None:
        self.page("```sh\nmake coffee && make tea   # both\n```\n")
        self.assertEqual(list(commands(self.root)), ["make coffee", "make tea"])
        with self.assertRaises(
            FileNotFoundError
        ):  # the tree that the table speaks of is not here ...
            check_table(self.root)
        root = pathlib.Path(__file__).parents[2]
        self.assertEqual(check_table(root), [])  # ... but there
        self.assertEqual(check_scripts(root, SCRIPTS), [])
        self.assertEqual(check_code(root, CODE), [])


if __name__ == "__main__":
    unittest.main()
