"""No two folders of a room include each other, also not by way of a third.

  folder_circles.py [ROOT]

Reads every #include "..." of the rooms and prints the folders that lie on a circle. Files that lie
beside the folders, such as server/owner/app.cpp, are no folder. Exit status: 0 none, 1 some, 2
there was nothing to check.
"""

import pathlib
import re
import sys

ROOMS = ("core", "hw", "server", "client", "proto")
WINGS = (["server", "owner"], ["server", "front"])  # their folders are a level deeper


def folder(path):
    """"core/src/tick/a.hpp" and "haptic/core/tick/a.hpp" are both in "core/tick"."""
    parts = [p for p in pathlib.PurePath(path).parts[:-1] if p not in ("include", "src", "haptic")]
    parts = parts[1:] if parts[:1] == parts[1:2] else parts  # core/include/haptic/core/tick
    depth = 3 if parts[:2] in WINGS else 2
    return "/".join(parts[:depth]) if len(parts) >= depth and parts[0] in ROOMS else None


def edges(root):
    """{folder: folders that it includes}"""
    found = {}
    for room in ROOMS:
        for file in (root / room).rglob("*.[ch]*"):
            here = folder(file.relative_to(root))
            if here is None or file.suffix not in (".hpp", ".cpp", ".h", ".c"):
                continue
            included = re.findall(r'^\s*#\s*include\s+"([^"]+)"', file.read_text(), re.M)
            found.setdefault(here, set()).update(
                there for there in map(folder, included) if there not in (None, here))
    return found


def reached(graph, start):
    seen, open_ends = set(), [start]
    while open_ends:
        for there in graph.get(open_ends.pop(), ()):
            if there not in seen:
                seen.add(there)
                open_ends.append(there)
    return seen


def main():
    here = pathlib.Path(__file__).parents[2]
    graph = edges(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else here)
    if not graph:
        print("folder_circles: no sources", file=sys.stderr)
        return 2
    circles = [(start, there) for start in sorted(graph) for there in sorted(graph[start])
               if start in reached(graph, there)]
    for start, there in circles:
        print(f"{start} includes {there}, and {there} leads back to {start}")
    return 1 if circles else 0


sys.exit(main())
