#!/usr/bin/env python3
"""Every command that the documents show is run by a test, and every piece of C++ and Python
compiled.

    documented_commands.py SOURCE [PROGRAMS]

Lines of ```sh blocks are commands. Each is found in the table below: either it is run here, against
a hapticd of this test's own (programs from PROGRAMS, a build folder), or the table names the test
that runs it, which has to exist. A command that is not in the table fails, and so does an entry
that no document needs. Of whatever else names one of the programs with options, in code or between
back-ticks, the options have to be in the program's help. Every script that a document names between
back-ticks is there, its arguments are words of its own usage, and SCRIPTS names the test that runs
it.
"""

import os
import contextlib
import pathlib
import re
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import time

PROGRAMS = {
    "hapticd": "server/hapticd",
    "hapticctl": "client/hapticctl",
    "haptic-board-emulator": "hw/haptic-board-emulator",
}
# Commands that run here, in the order of client/README.md; a command without an end is interrupted
# after so many seconds.
RUN = {
    "hapticctl info": None,
    "hapticctl health": None,
    "hapticctl watch": 1.0,
    "hapticctl engage --hold": 2.0,
    "hapticctl link": None,
    "hapticctl estop": None,
    "hapticctl clear-fault": None,
    "hapticctl restart-front": None,
}
# Commands that another test runs: that test's file, and the text in it that shows so.
ELSEWHERE = {
    "server/demo.sh --delay 100": ("tests/system/demo_test.sh", "--delay 100"),
    "tests/run.sh": (".ci/run", "tests/run.sh"),
    "node examples/virtual_wall.mjs http://127.0.0.1:29473 TOKEN": (
        "tests/client/js/example_test.mjs",
        "examples/virtual_wall.mjs",
    ),
    "build/release/server/hapticd --scene finger_soft_grasp "
    "--set 'server.web.printed=\"control\"'": (
        "tests/page/mujoco_test.mjs",
        'startHapticd(t, "control", scene)',
    ),
    "docker/install-deps.sh": ("tests/run.sh", "docker/install-deps.sh"),
    "docker/test.sh": ("tests/package/CMakeLists.txt", "docker/test.sh"),
    "docker/install-deps.sh build node": ("server/demo.sh", "packages+=(node)"),
    "cmake --preset release -DHAPTIC_BUILD_TESTS=OFF": (
        "server/demo.sh",
        "cmake --preset release -DHAPTIC_BUILD_TESTS=OFF",
    ),
    "cmake --preset release": ("tests/run.sh", "cmake --preset"),
    "cmake --build --preset release": ("tests/run.sh", "cmake --build --preset"),
    "cmake --build --preset product": ("CMakePresets.json", '"name": "product"'),
    'cmake --install build/release --prefix "$HOME/.local"': (
        "tests/package/install_test.sh",
        'cmake --install "$build" --prefix',
    ),
    "tests/mutation/run.py": ("tests/mutation/CMakeLists.txt", "/run.py"),
    "hapticctl doctor": ("tests/hapticctl/doctor_test.cpp", "MeasuresThisVeryHost"),
    "hapticctl calibrate": ("tests/hapticctl/calibrate_test.py", '"calibrate", "--output"'),
    "hapticctl find": ("tests/hapticctl/find_test.py", '*words, "find"]'),
    "tests/relay/matrix.sh": ("tests/relay/matrix_test.sh", "tests/relay/matrix.sh"),
    "tests/relay/matrix.sh --network": (
        "tests/CMakeLists.txt",
        "haptic_test_program(network network",
    ),  # minutes
    "tests/relay/matrix.sh --network --calm": ("tests/CMakeLists.txt", "LABELS calm"),  # minutes
    'export PKG_CONFIG_PATH="$HOME/.local/lib/pkgconfig"': (
        "tests/package/install_test.sh",
        "export PKG_CONFIG_PATH=",
    ),
    "g++ -std=c++20 first.cpp $(pkg-config --cflags --libs haptic-client) -o first": (
        "tests/package/install_test.sh",
        "$(pkg-config --cflags --libs haptic-client)",
    ),
    '"$HOME/.local/bin/hapticd" --scene finger_constant': (
        "tests/server/owner/scene/shipped_scenes_test.cpp",
        "AProgramFindsItsShareDirectory",
    ),
    "./first": ("tests/checks/CMakeLists.txt", "NAME readme.first_client"),
}
# tests/relay/README.md, "The relay by hand": they run side by side until the last has ended.
BY_HAND = [
    "build/release/server/hapticd --scene server/scenes/finger_constant.textproto "
    "--set 'server.udp_listen=\"127.0.0.1:29471\"'",
    "build/release/tests/relay/haptic-relay "
    "--scenario tests/relay/scenarios/loss_05.textproto --tcp 29470 --udp 29471",
    "build/release/client/hapticctl --server 127.0.0.2:29470 watch",
]
# Scripts that documents name, and the file that runs each. A script that takes minutes is run for
# its help and its refusals only; its parts have tests.
SCRIPTS = {
    ".ci/run": (
        "CONTRIBUTING.md",
        "`.ci/run`",
    ),  # run by hand or by CI: it contains this test
    "docker/install-deps.sh": ELSEWHERE["docker/install-deps.sh"],
    "docker/test.sh": ELSEWHERE["docker/test.sh"],
    "server/demo.sh": ("tests/system/demo_test.sh", '/server" && pwd)/demo.sh'),
    "docker/haproxy/test.sh": ("tests/CMakeLists.txt", "docker/haproxy/test.sh"),
    "tests/run.sh": ELSEWHERE["tests/run.sh"],
    "tests/lint.sh": ("tests/checks/CMakeLists.txt", "../lint.sh tidy"),
    "tests/checks/include_direction.sh": ("tests/checks/CMakeLists.txt", "include_direction.sh"),
    "tests/checks/front_links.sh": ("tests/checks/CMakeLists.txt", "/front_links.sh $<TARGET_FILE"),
    "tests/checks/owner_links.sh": ("tests/checks/CMakeLists.txt", "/owner_links.sh $<TARGET_FILE"),
    "tests/checks/firmware.sh": ("tests/checks/CMakeLists.txt", "firmware.sh arm-none-eabi-gcc"),
    "tests/relay/matrix.sh": ELSEWHERE["tests/relay/matrix.sh"],
    "tests/hostile/run.sh": ("tests/hostile/CMakeLists.txt", "/run.sh --build"),
    "tests/hostile/kernel.sh": ("tests/hostile/CMakeLists.txt", "/kernel.sh"),
    "tests/report/run.sh": ("tests/report/run_test.sh", '"$here/run.sh" --build'),
    "tests/bench/run.sh": ("tests/checks/long_commands_test.sh", "tests/bench/run.sh"),
    "tests/bench/network.sh": ("tests/checks/long_commands_test.sh", "tests/bench/network.sh"),
    "tests/bench/soak.sh": ("tests/checks/long_commands_test.sh", "tests/bench/soak.sh"),
    "tests/bench/serial.sh": ("tests/checks/long_commands_test.sh", "tests/bench/serial.sh"),
    "tests/churn/run.sh": ("tests/checks/long_commands_test.sh", "tests/churn/run.sh"),
    "tests/fuzz/run.sh": ("tests/checks/long_commands_test.sh", "tests/fuzz/run.sh"),
}
# Pieces of code per page and language, and the file that compiles or runs them.
CODE = {
    ("README.md", "cpp"): (1, "tests/checks/CMakeLists.txt", "readme_first_client"),
    ("client/README.md", "cpp"): (6, "tests/checks/CMakeLists.txt", "client/README.md cpp 6"),
    ("client/README.md", "python"): (3, "tests/client/python/session_test.py", '"```python\\n"'),
    ("hw/README.md", "cpp"): (1, "tests/checks/CMakeLists.txt", "haptic_readme_code(hw 1 "),
}
SCRIPT = re.compile(
    r"^((?:[A-Z_]+=\S+ )*)((?:\.ci|docker|server|tests)/(?:run|\S+\.sh))((?: .*)?)$"
)


def pages(root: pathlib.Path) -> list[pathlib.Path]:
    return [
        page
        for page in sorted(root.rglob("*.md"))
        if not {"build", ".git", "report"} & set(page.relative_to(root).parts)
    ]


def commands(root: pathlib.Path) -> dict[str, str]:
    """Command -> its page. `a && b` is two commands."""
    found = {}
    for page in pages(root):
        for block in re.findall(
            r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S
        ):
            for line in block.splitlines():
                for part in line.split(" #")[0].split("&&"):
                    if part.strip():
                        found[part.strip()] = str(page.relative_to(root))
    return found


def check_table(root: pathlib.Path) -> list[str]:
    wrong = []
    shown = commands(root)
    for command, page in shown.items():
        if command not in RUN and command not in ELSEWHERE and command not in BY_HAND:
            wrong.append(f"{page}: no test runs `{command}`")
    for command in [*RUN, *ELSEWHERE, *BY_HAND]:
        if command not in shown:
            wrong.append(f"documented_commands.py: no document shows `{command}`")
    for command, (file, words) in [*ELSEWHERE.items(), *SCRIPTS.items()]:
        if words not in (root / file).read_text(encoding="utf-8"):
            wrong.append(f"{file} does not run `{command}`: no '{words}' in it")
    return wrong


def scripts(root: pathlib.Path) -> list[tuple[str, str, list[str], str]]:
    """(variables, script, arguments, page) of every script that a page names between back-ticks."""
    found = []
    for page in pages(root):
        text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
        for span in re.findall(r"`([^`]+)`", text):
            if match := SCRIPT.match(" ".join(span.split())):
                arguments = shlex.split(match[3])
                if "--" in arguments:  # those behind it are another program's
                    arguments = arguments[: arguments.index("--")]
                found.append((match[1], match[2], arguments, str(page.relative_to(root))))
    return found


def check_scripts(root: pathlib.Path, known: dict[str, tuple[str, str]]) -> list[str]:
    """Options and words of each shown command must appear in the script's usage, the comment at its
    top; `a|b` counts as two words."""
    wrong = []
    shown = scripts(root)
    for variables, script, arguments, page in shown:
        if script not in known:
            wrong.append(f"{page}: no test runs `{script}`")
        if not os.access(root / script, os.X_OK):
            wrong.append(f"{page}: `{script}` is not there, or no program")
            continue
        text = (root / script).read_text(encoding="utf-8")
        usage = "\n".join(
            line for line in text.split("\n\n")[0].splitlines() if line.startswith("#")
        )
        for variable in re.findall(r"([A-Z_]+)=", variables):
            if not re.search(rf"\b{variable}\b", text):
                wrong.append(f"{page}: `{script}` knows no {variable}")
        if script.startswith("tests/checks/"):
            continue  # their arguments are the compiler's
        for word in (w for argument in arguments for w in argument.split("|")):
            if word.isdigit() or re.fullmatch(
                r"[A-Z]+(\.[a-z]+)?", word
            ):  # a number; a place for a value
                continue
            if not re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", usage):
                wrong.append(f"{page}: `{script}` says nothing of {word}")
    named = {script for _, script, _, _ in shown}
    wrong += [
        f"documented_commands.py: no document names `{script}`"
        for script in known
        if script not in named
    ]
    return wrong


def check_code(root: pathlib.Path, known: dict[tuple[str, str], tuple[int, str, str]]) -> list[str]:
    """Code of a page has a test, all of it; Python compiles."""
    wrong = []
    shown: dict[tuple[str, str], int] = {}
    for page in pages(root):
        name = str(page.relative_to(root))
        for language, block in re.findall(
            r"^```(cpp|python)\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S
        ):
            shown[name, language] = shown.get((name, language), 0) + 1
            if language == "python":
                compile(block, name, "exec")
    for place, count in shown.items():
        if known.get(place, (0,))[0] != count:
            wrong.append(
                f"{place[0]}: {count} pieces of {place[1]}, tested are {known.get(place, (0,))[0]}"
            )
    for place, (_, file, words) in known.items():
        if place not in shown:
            wrong.append(f"documented_commands.py: {place[0]} has no {place[1]}")
        elif words not in (root / file).read_text(encoding="utf-8"):
            wrong.append(f"{file} does not test the {place[1]} of {place[0]}: no '{words}' in it")
    return wrong


def free_ports() -> tuple[int, int]:
    """Two different ports below those that the kernel chooses, so that no other test gets them."""
    free = []
    for port in range(12_000 + 37 * os.getpid() % 17_000, 32_000):
        with socket.socket() as tcp, socket.socket(
            type=socket.SOCK_DGRAM
        ) as udp, contextlib.suppress(OSError):
            tcp.bind(("127.0.0.1", port))
            udp.bind(("127.0.0.1", port))
            free.append(port)
            if len(free) == 2:
                return free[0], free[1]
    raise AssertionError("no free port on 127.0.0.1")


def run_by_hand(root: pathlib.Path, programs: pathlib.Path) -> list[str]:
    """Runs the server, the relay and a watcher behind it, in the page's order, on free ports."""
    tcp, udp = map(str, free_ports())
    made = [
        [
            w.replace("29470", tcp).replace("29471", udp).replace("build/release", str(programs))
            for w in shlex.split(command)
        ]
        for command in BY_HAND
    ]
    made[0] += [
        "--listen",
        f"127.0.0.1:{tcp}",
        "--realtime=off",
        "--set",
        "loop.late_bucket_full=1000000",
        "--set",
        "loop.loop_late_fault={seconds: 10}",
    ]
    beside = []
    try:
        for command in made[:-1]:
            beside.append(
                subprocess.Popen(
                    command, cwd=root, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
                )
            )
        watch: list[str] = []
        latest = time.monotonic() + 60
        while time.monotonic() < latest:
            watcher = subprocess.Popen(
                [*made[-1], "--json"],
                cwd=root,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            time.sleep(1.0)
            watcher.send_signal(signal.SIGINT)
            output, _ = watcher.communicate(timeout=30)
            watch.append(output)
            if watcher.returncode == 0 and '"x_probe"' in output:
                return []
            if any(process.poll() is not None for process in beside):
                break
        return [
            f"`{BY_HAND[-1]}` showed no state: {watch[-1]}; of the others ended: "
            f"{[process.poll() for process in beside]}"
        ]
    finally:
        for process in reversed(beside):
            process.terminate()
            process.wait(timeout=10)


def run_all(root: pathlib.Path, programs: pathlib.Path) -> list[str]:
    """As the page says: while a hapticd of the soft grasp runs."""
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        address = f"unix:{folder}/socket"
        server = subprocess.Popen(
            [
                programs / "server/hapticd",
                "--scene",
                root / "server/scenes/finger_soft_grasp.textproto",
                "--realtime=off",
                "--listen",
                address,
                "--set",
                "loop.late_bucket_full=1000000",
                "--set",
                "loop.loop_late_fault={seconds: 10}",
            ],
            stderr=subprocess.DEVNULL,
        )
        try:
            while (
                subprocess.run(
                    [programs / "client/hapticctl", "--server", address, "health"],
                    capture_output=True,
                ).returncode
                != 0
            ):
                time.sleep(0.1)
            for command, seconds in RUN.items():
                words = shlex.split(command)
                process = subprocess.Popen(
                    [programs / "client" / words[0], "--server", address, *words[1:]],
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                )
                if seconds is not None:
                    time.sleep(seconds)
                    process.send_signal(signal.SIGINT)
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
    for page in pages(root):
        for name, rest in re.findall(
            rf"(?:^|[`/ ])({word})( [^`\n#|]*)", page.read_text(encoding="utf-8"), re.M
        ):
            used = {w for w in re.findall(r"(?<!\S)\[?(--[a-z][a-z-]*)", rest)}
            command = (
                next((w for w in rest.split() if w.isalpha()), "") if name == "hapticctl" else ""
            )
            if used:
                found.setdefault((name, command), set()).update(used)
    return found


def check_options(root: pathlib.Path, programs: pathlib.Path) -> list[str]:
    def known(*command: str) -> set[str]:
        shown = subprocess.run(
            [*command, "--help"], capture_output=True, text=True, check=True
        ).stdout
        return set(re.findall(r"--[a-z][a-z-]*", shown))

    wrong = []
    for (name, command), used in options(root).items():
        program = str(programs / PROGRAMS[name])
        allowed = known(program) | (known(program, command) if command else set())
        wrong += [
            f"documents: `{name} {command}` has no {option}" for option in sorted(used - allowed)
        ]
    return wrong


def main() -> None:
    root = pathlib.Path(sys.argv[1])
    wrong = check_table(root) + check_scripts(root, SCRIPTS) + check_code(root, CODE)
    if len(sys.argv) > 2:
        programs = pathlib.Path(sys.argv[2])
        wrong += (
            check_options(root, programs) + run_all(root, programs) + run_by_hand(root, programs)
        )
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(commands(root))} commands, {len(SCRIPTS)} scripts")


if __name__ == "__main__":
    os.environ.setdefault("TERM", "dumb")
    main()
