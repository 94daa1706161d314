#!/usr/bin/env python3
"""Every command that the documents show is run by a test.

    documented_commands.py SOURCE [PROGRAMS]

Lines of ```sh blocks are commands. Each is found in the table below: either it is run here, against a hapticd of
this test's own (programs from PROGRAMS, a build folder), or the table names the test that runs it, which has to
exist. A command that is not in the table fails, and so does an entry that no document needs. Of whatever else names one
of the programs with options, in code or between back-ticks, the options have to be in the program's help.
"""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time

PROGRAMS = {"hapticd": "server/hapticd", "hapticctl": "client/hapticctl",
            "haptic-board-emulator": "hw/haptic-board-emulator", "haptic-make-motion": "hw/haptic-make-motion"}
# What is run here, in the order of client/README.md; seconds after which an open end is interrupted.
RUN = {
    "hapticctl info": None,
    "hapticctl health": None,
    "hapticctl watch": 1.0,
    "hapticctl engage --hold": 2.0,
    "hapticctl link": None,
    "hapticctl estop": None,
    "hapticctl clear-fault": None,
}
# What another test runs, and words of that test's definition or script which show it.
ELSEWHERE = {
    "server/demo.sh": ("tests/system/demo_test.sh", "/server\" && pwd)/demo.sh"),
    "tests/run.sh": (".ci/run", "tests/run.sh"),
    "docker/install-deps.sh": ("tests/run.sh", "docker/install-deps.sh"),
    "docker/test.sh": ("tests/package/CMakeLists.txt", "docker/test.sh"),
    "cmake --preset release": ("tests/run.sh", "cmake --preset"),
    "cmake --build --preset release": ("tests/run.sh", "cmake --build --preset"),
    'cmake --install build/release --prefix "$HOME/.local"':
        ("tests/package/install_test.sh", 'cmake --install "$build" --prefix'),
    "hapticctl doctor": ("tests/hapticctl/doctor_test.cpp", "MeasuresThisVeryHost"),
    "hapticctl calibrate": ("tests/hapticctl/calibrate_test.py", '"calibrate", "--output"'),
    "tests/relay/matrix.sh": ("tests/relay/matrix_test.sh", "tests/relay/matrix.sh"),
    "tests/relay/matrix.sh --network": ("tests/relay/network_matrix_test.cpp", "TEST"),
    "build/release/server/hapticd --scene server/scenes/finger_constant.textproto --set 'server.udp_listen=\"127.0.0.1:50052\"'":
        ("tests/relay/daemon.cpp", "udp_listen"),
    "build/release/tests/haptic-relay --scenario tests/relay/scenarios/loss_05.textproto --tcp 50051 --udp 50052":
        ("docker/compose.yaml", "haptic-relay --scenario"),
    "build/release/client/hapticctl --server 127.0.0.2:50051 watch":
        ("tests/checks/documented_commands.py", '"hapticctl watch"'),
    "PYTHONPATH=build/release/client/python python3 client/python/examples/ages.py":
        ("tests/client/python/session_test.py", '"ages.py"'),
    "(cd build/release": ("tests/package/deb_test.sh", "cpack -G DEB"),
    "cpack -G DEB)": ("tests/package/deb_test.sh", "cpack -G DEB"),
}


def commands(root: pathlib.Path) -> dict[str, str]:
    """Command -> where it stands. `a && b` is two."""
    found = {}
    for page in sorted(root.rglob("*.md")):
        if {"build", ".git", "report"} & set(page.relative_to(root).parts):
            continue
        for block in re.findall(r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            for line in block.splitlines():
                for part in line.split(" #")[0].split("&&"):
                    if part.strip():
                        found[part.strip()] = str(page.relative_to(root))
    return found


def check_table(root: pathlib.Path) -> list[str]:
    wrong = []
    shown = commands(root)
    for command, page in shown.items():
        if command not in RUN and command not in ELSEWHERE:
            wrong.append(f"{page}: no test runs `{command}`")
    for command in [*RUN, *ELSEWHERE]:
        if command not in shown:
            wrong.append(f"documented_commands.py: no document shows `{command}`")
    for command, (file, words) in ELSEWHERE.items():
        if words not in (root / file).read_text(encoding="utf-8"):
            wrong.append(f"{file} does not run `{command}`: no '{words}' in it")
    return wrong


def run_all(root: pathlib.Path, programs: pathlib.Path) -> list[str]:
    """As the page says: beside a running hapticd of the soft grasp."""
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        address = f"unix:{folder}/socket"
        server = subprocess.Popen(
            [programs / "server/hapticd", "--scene", root / "server/scenes/finger_soft_grasp.textproto",
             "--realtime=off", "--listen", address, "--set", "loop.late_bucket_full=1000000",
             "--set", "loop.loop_late_fault={seconds: 10}"], stderr=subprocess.DEVNULL)
        try:
            while subprocess.run([programs / "client/hapticctl", "--server", address, "health"],
                                 capture_output=True).returncode != 0:
                time.sleep(0.1)
            for command, seconds in RUN.items():
                words = shlex.split(command)
                process = subprocess.Popen(
                    [programs / "client" / words[0], "--server", address, *words[1:]],
                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                if seconds is not None:
                    time.sleep(seconds)
                    process.send_signal(2)
                output, _ = process.communicate(timeout=30)
                if process.returncode != 0 or not output:
                    wrong.append(f"`{command}` ended with {process.returncode}: {output}")
        finally:
            server.terminate()
            if server.wait(timeout=10) != 0:
                wrong.append("hapticd did not end with 0")
    return wrong


def options(root: pathlib.Path) -> dict[tuple[str, str], set[str]]:
    """(program, subcommand or nothing) -> the options that the documents give it."""
    found: dict[tuple[str, str], set[str]] = {}
    word = "|".join(PROGRAMS)
    for page in root.rglob("*.md"):
        if {"build", ".git", "report"} & set(page.relative_to(root).parts):
            continue
        for name, rest in re.findall(rf"(?:^|[`/ ])({word})( [^`\n#|]*)", page.read_text(encoding="utf-8"), re.M):
            used = {w for w in re.findall(r"(?<!\S)\[?(--[a-z][a-z-]*)", rest)}
            command = next((w for w in rest.split() if w.isalpha()), "") if name == "hapticctl" else ""
            if used:
                found.setdefault((name, command), set()).update(used)
    return found


def check_options(root: pathlib.Path, programs: pathlib.Path) -> list[str]:
    def known(*command: str) -> set[str]:
        shown = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True).stdout
        return set(re.findall(r"--[a-z][a-z-]*", shown))

    wrong = []
    for (name, command), used in options(root).items():
        program = str(programs / PROGRAMS[name])
        allowed = known(program) | (known(program, command) if command else set())
        wrong += [f"documents: `{name} {command}` has no {option}" for option in sorted(used - allowed)]
    return wrong


def main() -> None:
    root = pathlib.Path(sys.argv[1])
    wrong = check_table(root)
    if len(sys.argv) > 2:
        programs = pathlib.Path(sys.argv[2])
        wrong += check_options(root, programs) + run_all(root, programs)
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(commands(root))} commands")


if __name__ == "__main__":
    os.environ.setdefault("TERM", "dumb")
    main()
