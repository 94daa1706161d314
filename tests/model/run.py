#!/usr/bin/env python3
"""Does the model of states, leases and stops keep its promises? (README.md)

    tests/model/run.py [--scratch FOLDER]                  the usual bounds, a minute
    tests/model/run.py --exhaustive                        the wide bounds
    tests/model/run.py --mutations                         each promise can be broken
    tests/model/run.py --replay PROGRAM [--steps N] [--seed N]
                                                           the product's steps are the model's

PROGRAM is haptic_model_steps. Exit status 1 if a promise is broken, if a statement of the model was
not reached, if a mutation is not caught or if a step of the product is not one of the model; 77 if
spin is not here.
"""

import argparse
import os
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
# A d_step is an "atomic" here: so the verifier counts each statement within.
REPLAY = dict.fromkeys(BOUNDS, 1) | {"SESSIONS": 3, "RECORDS": 360, "CLEARS": 2, "REPLAY": 1,
                                     "d_step": "atomic"}
MILLION = 1_000_000
PART = 100_000  # steps replayed at once: all their states are kept
NOT_DEMANDED = ["(promised)", "(asked_engage)", "asked_engage = ", "{c_code}"]  # by README.md
WIDE = [LEASES | {"SESSIONS": 3}, LEASES | {"RECORDS": 2, "CLOSES": 0}, BOUNDS | {"CLEARS": 2},
        BOUNDS | {"FAULTS": 1}, BOUNDS | {"RESUMES": 1, "CLOSES": 1}]


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
                    ["gcc", "-O3", "-w", "-DSAFETY", "-DNOREDUCE", "-DPEG", *flags, "-o", "pan",
                     "pan.c"]):
        status, said = call(command, folder)
        if status != 0:
            raise Failure(f"{' '.join(command)}: {said}")


def transitions(folder, said, copies):
    """How often each transition of the model was taken, by line and text without its numbers; with
    `copies` each by itself if an inline stands at several places."""
    made = re.findall(r"case (\d+): // STATE \d+ - owner.pml:(\d+) - \[(.*)\]",
                      (folder / "pan.m").read_text())
    taken = {number: int(times) for times, number in re.findall(r"(\d+)\ttrans +(\d+) ", said)}
    counts = Counter()
    for number, line, text in made:
        if text == "-end-":
            continue
        key = (int(line), re.sub(r"\d+", "", text)[:LOOK], number if copies else "")
        counts[key] += taken.get(number, 0)
    return counts


def search(name, folder, bounds):
    """Every state within these bounds. The transitions, and how often each was taken."""
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
    return transitions(folder, said, copies=False)


def replay(folder, program, steps, seed):
    """Are random steps of the product steps of the model? From a million on they must take each
    transition, for which there may be three times as many."""
    place, file = folder / "replay", folder / "steps"
    verifier(place, MODEL.read_text(), REPLAY, "-DVECTORSZ=4096")
    results, done, demanding = [], 0, steps >= MILLION
    while done < steps or demanding and done < 3 * steps and never_taken(results, NOT_DEMANDED):
        status, said = call([program, str(seed), str(PART), file], folder)
        if status != 0:
            raise Failure(f"{program}: status {status}: {said}")
        _, said = call(["./pan", "-E", "-m2000000"], place, env=os.environ | {"STEPS": str(file)})
        found = re.search(r"replayed (\d+) of (\d+) steps.*", said)
        if not found or found.group(1) != found.group(2) or "errors: 0" not in said:
            raise Failure(f"seed {seed}: {found.group(0) if found else said}; {file}")
        print(f"seed {seed}: {found.group(0)}", flush=True)
        results.append(transitions(place, said, copies=True))
        done += int(found.group(2))
        seed += 1
    if demanding:
        tell_never_taken(results, NOT_DEMANDED)


def never_taken(results, not_demanded=()):
    """The transitions that no result took; of the texts not demanded one copy may be missing."""
    taken = sum(results, start=Counter())
    never = sorted(key for key in set().union(*results) if taken[key] == 0)
    for text in not_demanded:
        copy = next((key for key in never if key[1] == text), None)
        if copy is not None:
            never.remove(copy)
    return never


def tell_never_taken(results, not_demanded=()):
    """Fails if there are some."""
    never = never_taken(results, not_demanded)
    for line, text, _ in never:
        print(f"owner.pml:{line}: never taken: {text}")
    if never:
        raise Failure(f"{len(never)} transitions of the model were never taken")
    print(f"taken: {len(set().union(*results)) - len(not_demanded)} transitions", flush=True)


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
    parser.add_argument("--replay", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=MILLION)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if shutil.which("spin") is None:
        print("spin is not here: docker/install-deps.sh test")
        return 77
    folder = given.scratch.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        if given.mutations:
            mutations(folder)
        elif given.replay:
            replay(folder, given.replay.resolve(), given.steps, given.seed)
        else:
            bounds = USUAL + WIDE if given.exhaustive else USUAL
            with ThreadPoolExecutor(2) as two:
                results = list(two.map(search, range(len(bounds)), [folder] * len(bounds), bounds))
            tell_never_taken(results)
    except Failure as failure:
        print(failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
