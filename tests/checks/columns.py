#!/usr/bin/env python3
"""No line over 100 columns (CONTRIBUTING.md#style).

    columns.py ROOT

A line passes if it cannot be broken: a table or code block in Markdown, a word of more than 60
characters, a directive of tests/report/index.in. Generated and foreign files are left out.
"""

import pathlib
import subprocess
import sys

COLUMNS = 100
LONGEST_WORD = 60  # a longer one (a URL, a pattern, a list without blanks) may stand alone
FOREIGN = ("proto/google/", "proto/grpc/", "LICENSE")
GENERATED = (".csv", ".json", ".png", ".svg", ".textproto", ".binpb", ".tar.xz")


def unbreakable(line: str, file: str, in_code: bool) -> bool:
    if file.endswith(".md") and (in_code or line.lstrip().startswith("|")):
        return True
    if file.endswith("index.in") and line.startswith("@"):
        return True
    return any(len(word) > LONGEST_WORD for word in line.split())


def long_lines(root: pathlib.Path, file: str) -> list[str]:
    found, in_code = [], False
    for number, line in enumerate((root / file).read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            in_code = not in_code
        if len(line) > COLUMNS and not unbreakable(line, file, in_code):
            found.append(f"{file}:{number}: {len(line)} columns")
    return found


def main() -> int:
    root = pathlib.Path(sys.argv[1]).resolve()
    listed = subprocess.run(
        ["sh", "-c", '. "$0" && files_of "$1"', pathlib.Path(__file__).parent / "files.sh", root],
        capture_output=True,
        text=True,
        check=True,
    )
    files = [
        file
        for file in listed.stdout.split()
        if not file.startswith(FOREIGN)
        and not file.endswith(GENERATED)
        and (root / file).is_file()
    ]
    found = [line for file in files for line in long_lines(root, file)]
    print("\n".join(found) if found else f"{len(files)} files checked")
    return 1 if found else 0 if files else 2


if __name__ == "__main__":
    sys.exit(main())
