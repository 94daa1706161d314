#!/usr/bin/env python3
"""Does a test fail if a line that safety depends on is wrong? (README.md)

    tests/mutation/run.py [--scratch FOLDER] [--only TEXT] [--jobs N]
    tests/mutation/run.py --check | --list

Copies the tree into FOLDER (default: build/mutation), never edits the checkout, puts every mutation
of mutations.toml into the copy behind a switch, and builds the named test programs once. Then it
runs the named tests with one mutation switched on after the other, and prints "caught" or
"SURVIVED". Exit status 1 if fewer than 75 are caught, or if an entry does not apply, the copy does
not compile or an entry names no test. FOLDER keeps its build: a second run is quick.

    --only TEXT   the mutations whose name or file has TEXT
    --check       only that each line stands exactly once in its file; builds nothing
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIST = pathlib.Path(__file__).with_name("mutations.toml")
MUST_BE_CAUGHT = 75
# Before the first line of each file that has a mutation, in C or C++.
SWITCH = """#include <stdlib.h>
#ifndef HAPTIC_MUTANT_SWITCH
#define HAPTIC_MUTANT_SWITCH
static inline int haptic_mutant(int number) {
  static int on = -1;
  const char* const told = on < 0 ? getenv("HAPTIC_MUTANT") : "";
  if (on < 0) on = told != NULL ? atoi(told) : 0;
  return on == number;
}
#endif
"""
LONGEST_TEST = 300  # s; a mutation may make a test wait for ever


@dataclass(frozen=True)
class Mutation:
    """A line with an expression that would be another one, and the tests that must fail then."""

    number: int  # its switch, 1, 2, ...
    name: str
    file: str
    line: str  # with the expression in brackets
    becomes: str
    program: str
    tests: str

    def applied(self, text: str) -> str:
        """`text` of the file with the mutation behind its switch. ValueError: not possible."""
        brackets = re.fullmatch(r"(.*)\u27e6(.+)\u27e7(.*)", self.line)
        if not brackets:
            raise ValueError("its line has no expression in brackets")
        before, expression, after = brackets.groups()
        count = text.count(before + expression + after)
        if count != 1:
            raise ValueError(f"{self.file} has its line {count} times: must be once")
        switch = f"(haptic_mutant({self.number}) ? ({self.becomes}) : ({expression}))"
        return text.replace(before + expression + after, before + switch + after)


def read_list(file: pathlib.Path = LIST) -> list[Mutation]:
    entries = tomllib.loads(file.read_text(encoding="utf-8"))["mutation"]
    return [Mutation(number, **entry) for number, entry in enumerate(entries, 1)]


def misfits(mutations: list[Mutation], root: pathlib.Path) -> list[str]:
    """Which do not apply to the tree, one after the other, and why."""
    found, texts = [], {}
    for mutation in mutations:
        try:
            text = texts.get(mutation.file) or (root / mutation.file).read_text(encoding="utf-8")
            texts[mutation.file] = mutation.applied(text)
        except (ValueError, FileNotFoundError) as error:
            found.append(f"{mutation.name}: does not apply: {error}")
    return found


def mutated(text: str, mutations: list[Mutation]) -> str:
    """The text of a file with all of its mutations, behind their switches."""
    for mutation in mutations:
        text = mutation.applied(text)
    return SWITCH + text


def copy_tree(to: pathlib.Path, mutations: list[Mutation]) -> None:
    """What git knows or would add, with the mutations. A file that is the same keeps its time, and
    needs no build."""
    listed = subprocess.run(
        ["git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        check=True, capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        source, target = ROOT / name, to / name
        if not source.is_file():
            target.unlink(missing_ok=True)
            continue
        content = source.read_bytes()
        if here := [one for one in mutations if one.file == name]:
            content = mutated(content.decode(), here).encode()
        if not target.is_file() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            shutil.copymode(source, target)


class Scratch:
    """The copy of the tree, its build, and its tests."""

    def __init__(self, folder: pathlib.Path, jobs: int, mutations: list[Mutation]) -> None:
        self.folder = folder
        self.build_folder = folder / "build/release"
        self.jobs = jobs
        folder.mkdir(parents=True, exist_ok=True)
        copy_tree(folder, mutations)
        if shutil.which("ccache"):
            os.environ.setdefault("CMAKE_CXX_COMPILER_LAUNCHER", "ccache")
            os.environ.setdefault("CMAKE_C_COMPILER_LAUNCHER", "ccache")
        subprocess.run(["cmake", "--preset", "release", "--log-level=WARNING"], cwd=folder,
                       check=True, stdout=subprocess.DEVNULL)

    def build(self, programs: list[str]) -> str:
        """Empty if it went well, else the end of what the compiler said."""
        done = subprocess.run(
            ["cmake", "--build", self.build_folder, "--parallel", str(self.jobs), "--target",
             *programs], capture_output=True, text=True)
        return "" if done.returncode == 0 else done.stdout[-4000:] + done.stderr[-500:]

    def fails(self, mutation: Mutation, switched_on: bool) -> bool:
        """The tests of a mutation, with or without it. LookupError: there are none."""
        program = self.build_folder / "tests" / mutation.program
        environment = {**os.environ, "HAPTIC_MUTANT": str(mutation.number if switched_on else 0)}
        try:
            done = subprocess.run([program, f"--gtest_filter={mutation.tests}", "--gtest_brief=1"],
                                  cwd=self.folder, env=environment, capture_output=True, text=True,
                                  timeout=LONGEST_TEST)
        except subprocess.TimeoutExpired:
            return True
        if done.returncode == 0 and "[  PASSED  ] 0 tests" in done.stdout:
            raise LookupError(f"{mutation.program} has no test {mutation.tests}")
        return done.returncode != 0


def positive_control(scratch: Scratch, mutations: list[Mutation]) -> list[str]:
    """Without a mutation every named test is there and passes; else what is wrong."""
    wrong = scratch.build(sorted({mutation.program for mutation in mutations}))
    if wrong:
        return [f"the copy does not build:\n{wrong}"]
    found = []
    for mutation in {(one.program, one.tests): one for one in mutations}.values():
        try:
            if scratch.fails(mutation, switched_on=False):
                found.append(f"{mutation.program} {mutation.tests}: fails without a mutation")
        except LookupError as error:
            found.append(str(error))
    return found


def run(mutations: list[Mutation], scratch: Scratch, needed: int) -> int:
    """Exit status: 0 if at least `needed` are caught."""
    wrong = positive_control(scratch, mutations)
    if wrong:
        print("\n".join(wrong))
        return 1
    print("without a mutation all named tests pass", flush=True)
    caught = 0
    for mutation in mutations:
        fails = scratch.fails(mutation, switched_on=True)
        caught += fails
        print(f"{'caught' if fails else 'SURVIVED'}: {mutation.name} ({mutation.file})", flush=True)
    print(f"{caught} of {len(mutations)} mutations caught, at least {needed} must be")
    return 0 if caught >= needed else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scratch", type=pathlib.Path, default=ROOT / "build/mutation")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    mutations = [m for m in read_list() if arguments.only in m.name or arguments.only in m.file]
    if not mutations:
        parser.error(f"--only {arguments.only}: no mutation has that; --list shows all")
    if arguments.list:
        for mutation in mutations:
            print(f"{mutation.file}: {mutation.name}")
        return 0
    wrong = misfits(mutations, ROOT)
    if wrong or arguments.check:
        print("\n".join(wrong) or f"{len(mutations)} mutations apply")
        return 1 if wrong else 0
    needed = len(mutations) if arguments.only else MUST_BE_CAUGHT
    scratch = Scratch(arguments.scratch.resolve(), arguments.jobs, read_list())
    return run(mutations, scratch, needed)


if __name__ == "__main__":
    sys.exit(main())
