#!/usr/bin/env python3
"""A test's name says its rule in six words or fewer (CONTRIBUTING.md#tests).

    rule_names.py ROOT

A capital letter begins a word; an acronym or a number is one word.
"""

import pathlib
import re
import sys

MOST = 6
TEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z][a-z]*|[0-9]+[a-z0-9]*|[a-z]+")


def main() -> int:
    root = pathlib.Path(sys.argv[1])
    rules = [
        (file, suite, rule)
        for file in sorted((root / "tests").rglob("*.cpp"))
        for suite, rule in TEST.findall(file.read_text(encoding="utf-8"))
    ]
    too_long = [row for row in rules if len(WORD.findall(row[2])) > MOST]
    for file, suite, rule in too_long:
        words = len(WORD.findall(rule))
        print(f"{file.relative_to(root)}: {suite}.{rule}: {words} words, at most {MOST}")
    if not too_long:
        print(f"{len(rules)} rules checked")
    return 1 if too_long else 0 if rules else 2


if __name__ == "__main__":
    sys.exit(main())
