#!/usr/bin/env python3
"""Compiles each target outside tests/, and each folder of a test program, as one translation unit.

    batches.py COMPILE_COMMANDS

The release preset compiles sources in batches of a fixed number, so a new file moves those after
it into other batches: two equal names that are apart today may clash then. Prints one line per
target; exits with 1 if one does not compile.
"""

import json
import pathlib
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor


def targets(database: pathlib.Path) -> dict[str, list[dict[str, str]]]:
    """The C++ compilations by target (in tests: target and folder), in the order of their files."""
    root = pathlib.Path(__file__).resolve().parents[2]
    found: dict[str, list[dict[str, str]]] = {}
    for entry in sorted(json.loads(database.read_text()), key=lambda entry: entry["file"]):
        target = re.search(r"CMakeFiles/([^/]+)\.dir/", entry["command"])
        file = pathlib.Path(entry["file"])
        inside = file.is_relative_to(root) and not file.is_relative_to(root / "build")
        if not (target and inside and file.suffix == ".cpp"):
            continue
        name = target.group(1)
        if file.is_relative_to(root / "tests"):
            if not name.endswith("_tests"):
                continue
            name += f" {file.parent.relative_to(root)}"
        found.setdefault(name, []).append(entry)
    return found


def compile_as_one(target: str, entries: list[dict[str, str]]) -> str:
    """Returns the errors, or nothing. The flags are those of the first source."""
    words = shlex.split(entries[0]["command"])
    drop = {words.index("-o"), words.index("-o") + 1, words.index("-c"), words.index("-c") + 1}
    command = [word for place, word in enumerate(words) if place not in drop]
    command += ["-fsyntax-only", "-w", "-x", "c++", "-"]
    unit = "".join(f'#include "{entry["file"]}"\n' for entry in entries)
    run = subprocess.run(command, input=unit, capture_output=True, text=True, check=False,
                         cwd=entries[0]["directory"])
    return "" if run.returncode == 0 else run.stderr


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    found = targets(pathlib.Path(sys.argv[1]))
    if not found:
        print(f"{sys.argv[1]}: names no source of this project", file=sys.stderr)
        return 2
    with ThreadPoolExecutor(2) as pool:
        errors = dict(zip(found, pool.map(compile_as_one, found, found.values())))
    for target, text in errors.items():
        print(f"{target}: {len(found[target])} sources {'clash' if text else 'compile as one'}")
        if text:
            print(text, file=sys.stderr)
    return 1 if any(errors.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
