#!/usr/bin/env python3
"""The last line of tests/run.sh: how many tests passed, failed and were skipped, and why.

    tests/summary.py RESULTS.xml...      as ctest --output-junit writes them

A skipped test is not a passed one, though ctest counts it so; nor is what a test of Python left
out of itself (unittest's "skipped=1"). Exit status 1 if there are no results."""

import re
import sys
import xml.etree.ElementTree


def reason(output):
    """Why a test says that it was skipped: in one line."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    for i, line in enumerate(lines):
        if re.search(r": Skipped$", line) and i + 1 < len(lines):  # GoogleTest; the reason follows
            return lines[i + 1]
        said = re.search(r"skipped[:,] *(.+)", line, re.IGNORECASE)
        if said:
            return said.group(1)
    return lines[-1] if lines else "no reason given"


def parts_left_out(output):
    """(how many tests of its own a program of unittest skipped, why)."""
    count = sum(int(n) for n in re.findall(r"\(.*\bskipped=(\d+)", output))
    said = re.search(r"skipped ['\"](.+)['\"]", output)
    return count, said.group(1) if said else "its output says why"


def summary(files):
    passed = failed = 0
    skipped = {}  # reason -> names
    for file in files:
        for case in xml.etree.ElementTree.parse(file).getroot().iter("testcase"):
            name, output = case.get("name"), case.findtext("system-out") or ""
            if case.find("skipped") is not None or case.get("status") == "notrun":
                skipped.setdefault(reason(output), []).append(name)
            elif case.find("failure") is not None or case.get("status") == "fail":
                failed += 1
            else:
                passed += 1
                count, why = parts_left_out(output)
                if count:
                    skipped.setdefault(why, []).extend([f"{count} of {name}"])
    number = sum(map(len, skipped.values()))
    text = f"{passed} tests passed, {failed} failed, {number} skipped"
    whys = (f"{names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''} ({why})"
            for why, names in skipped.items())
    return text + (": " + "; ".join(whys) if skipped else ""), passed + failed + number


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if sys.argv[1:] in (["-h"], ["--help"]) else 2
    try:
        text, ran = summary(sys.argv[1:])
    except (OSError, xml.etree.ElementTree.ParseError) as error:
        print(f"summary.py: no results: {error}")
        return 1
    print(text)
    return 0 if ran else 1


if __name__ == "__main__":
    sys.exit(main())
