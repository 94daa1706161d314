#!/usr/bin/env python3
"""Does the model of states, leases and stops keep its promises? (README.md)

    tests/model/run.py [--scratch FOLDER]                  the usual bounds, a minute
    tests/model/run.py --exhaustive                        the wide bounds
    tests/model/run.py --mutations                         each promise can be broken

Exit status 1 if a promise is broken, if a statement of the model was not reached or if a mutation
is not caught; 77 if spin is not here.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

HERE = pathlib.Path(__file__).resolve().parent
MODEL = HERE / "owner.pml"
LOOK = 40  # characters of a statement
BOUNDS = {"SESSIONS": 1, "RECORDS": 1, "CLEARS": 1, "FAULTS": 0, "STOPS": 1, "RESUMES": 0,
          "CLOSES": 0}
LEASES = BOUNDS | {"SESSIONS": 2, "STOPS": 0, "RESUMES": 1, "CLOSES": 1}
USUAL = [BOUNDS, LEASES, BOUNDS | {"FAULTS": 1, "STOPS": 0}]
WIDE = [LEASES | {"SESSIONS": 3}, LEASES | {"RECORDS": 2, "CLOSES": 0}, BOUNDS | {"CLEARS": 2}]


class Failure(Exception):
    """What was not as it must be."""


def call(command, folder, **more):
    """Its output."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, **more)
    return done.returncode, done.stdout + done.stderr


def verifier(folder, model, bounds, *flags):
    """Makes `folder`/pan of the text of the model."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HERE, folder)
    (folder / "owner.pml").write_text(model)
    defines = [*(f"-D{name}={value}" for name, value in bounds.items())]
    for command in (["spin", *defines, "-a", "-o3", "owner.pml"],
                    ["gcc", "-O3", "-w", "-DSAFETY", "-DNOREDUCE", *flags, "-o", "pan", "pan.c"]):
        status, said = call(command, folder)
        if status != 0:
            raise Failure(f"{' '.join(command)}: {said}")


def statements(folder, said):
    """Of the model, as line and text: those that some step took, and those that none did. If an
    inline stands at several places, one of them is enough."""
    made = (folder / "pan.m").read_text()
    there = Counter((int(line), text[:LOOK]) for line, text in
                    re.findall(r"// STATE \d+ - owner.pml:(\d+) - \[(.*)\]", made))
    missing = Counter((int(line), text[:LOOK]) for line, text in
                      re.findall(r'owner.pml:(\d+), state \d+, "(.*)"', said) if text != "-end-")
    unreached = {which for which, n in missing.items() if n >= there[which]}
    return set(there) - unreached, unreached


def search(name, folder, bounds):
    """Every state within these bounds. The statements reached, and those that were not."""
    folder = folder / f"search{name}"
    verifier(folder, MODEL.read_text(), bounds)
    _, said = call(["./pan", "-m3000000"], folder)
    broken = re.search(r"pan:\d+: (.*)", said)
    if broken or "errors: 0" not in said:
        raise Failure(f"{bounds}: {broken.group(1) if broken else said}; the steps: {folder}")
    states = re.search(r"(\d+) states, stored", said).group(1)
    seconds = re.search(r"elapsed time ([\d.]+)", said).group(1)
    print(", ".join(f"{key} {value}" for key, value in bounds.items()),
          f": {states} states, {seconds} s", flush=True)
    return statements(folder, said)


def tell_unreached(results):
    """Fails if there is a statement that no result reached."""
    reached = set().union(*(result[0] for result in results))
    never = sorted(set().union(*(result[1] for result in results)) - reached)
    for line, text in never:
        print(f"owner.pml:{line}: not reached: {text}")
    if never:
        raise Failure(f"{len(never)} statements of the model were not reached")


def mutations(folder):
    """Each must break its promise."""
    model = MODEL.read_text()
    survived = 0
    entries = tomllib.loads((HERE / "mutations.toml").read_text())["mutation"]
    for number, entry in enumerate(entries):
        if model.count(entry["text"]) != 1:
            raise Failure(f"mutations.toml: {entry['text']!r}: must stand once in owner.pml")
        place = folder / f"mutation{number}"
        verifier(place, model.replace(entry["text"], entry["becomes"]),
                 BOUNDS | {"STOPS": 0} | entry.get("with", {}), "-DBFS", "-O1")
        said = call(["./pan"], place)[1]
        caught = f"assertion violated {entry['promise']} " in said
        survived += not caught
        print("caught" if caught else "SURVIVED", entry["promise"], flush=True)
    if survived:
        raise Failure(f"{survived} mutations were not caught")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scratch", type=pathlib.Path, default=pathlib.Path("build/model"))
    parser.add_argument("--exhaustive", action="store_true")
    parser.add_argument("--mutations", action="store_true")
    given = parser.parse_args()
    if shutil.which("spin") is None:
        print("spin is not here: docker/install-deps.sh test")
        return 77
    folder = given.scratch.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        if given.mutations:
            mutations(folder)
        else:
            bounds = USUAL + WIDE if given.exhaustive else USUAL
            with ThreadPoolExecutor(2) as two:
                results = list(two.map(search, range(len(bounds)), [folder] * len(bounds), bounds))
            tell_unreached(results)
    except Failure as failure:
        print(failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
