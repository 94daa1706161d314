#!/usr/bin/env python3
"""Milliseconds between two lines of hapticd's log, by the log's own times.

    log_span.py FILE FIRST LAST

FIRST and LAST are words of the lines; LAST has to be in the last line of the log. Ends with 1 if it
is not.
"""

import datetime
import sys


def stamp(line: str) -> datetime.datetime:
    return datetime.datetime.fromisoformat(line.split(" ", 1)[0])


def main() -> None:
    file, first, last = sys.argv[1:4]
    with open(file, encoding="utf-8") as log:
        lines = [line.rstrip("\n") for line in log]
    begin = next((line for line in reversed(lines) if first in line), None)
    if begin is None or last not in lines[-1]:
        sys.exit(f"log_span.py: no '{first}' ... '{last}' at the end of {file}")
    took = stamp(lines[-1]) - stamp(begin)
    print(took // datetime.timedelta(milliseconds=1))


if __name__ == "__main__":
    main()
