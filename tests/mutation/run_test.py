#!/usr/bin/env python3
"""The runner's own judgement: what is no mutation, and what makes it fail. Builds nothing."""

import contextlib
import io
import pathlib
import tempfile
import unittest

import run


LINE = "if (\u27e6a < b\u27e7) return;"


def mutation(number: int = 1, line: str = LINE) -> run.Mutation:
    return run.Mutation(number, f"the {number}.", "file.cpp", line, "true", "program", "Test.*")


class MadeScratch:
    """Answers as it is told instead of building: which mutations make a test fail."""

    def __init__(self, caught: set[int], passes: bool = True) -> None:
        self.caught = caught
        self.passes = passes

    def build(self, _programs: list[str]) -> str:
        return ""

    def fails(self, judged: run.Mutation, switched_on: bool) -> bool:
        return judged.number in self.caught if switched_on else not self.passes


def status(caught: set[int], needed: int, passes: bool = True) -> int:
    with contextlib.redirect_stdout(io.StringIO()):
        return run.run([mutation(1), mutation(2)], MadeScratch(caught, passes), needed)


class Runner(unittest.TestCase):
    def test_every_entry_applies(self) -> None:
        mutations = run.read_list()
        self.assertGreaterEqual(len(mutations), 45)
        self.assertEqual(len({one.name for one in mutations}), len(mutations))
        self.assertEqual(run.misfits(mutations, run.ROOT), [])

    def test_a_line_that_is_gone_is_an_error(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "file.cpp").write_text("if (a < b) return;\nif (c) return;\nif (c) return;\n")
            self.assertEqual(run.misfits([mutation()], root), [])
            self.assertIn("0 times", run.misfits([mutation(line="if (\u27e6d\u27e7)")], root)[0])
            self.assertIn("2 times", run.misfits([mutation(line="if (\u27e6c\u27e7)")], root)[0])
            self.assertIn("no expression", run.misfits([mutation(line="if (c)")], root)[0])

    def test_it_stands_behind_its_switch(self) -> None:
        self.assertEqual(mutation(7).applied("x;\nif (a < b) return;\n"),
                         "x;\nif ((haptic_mutant(7) ? (true) : (a < b))) return;\n")

    def test_survivors_count_against_it(self) -> None:
        self.assertEqual(status({1}, needed=1), 0)
        self.assertEqual(status({1}, needed=2), 1)

    def test_tests_must_pass_without_a_mutation(self) -> None:
        self.assertEqual(status({1, 2}, needed=1, passes=False), 1)


if __name__ == "__main__":
    unittest.main()
