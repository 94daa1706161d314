"""Files that are read: scenes, overrides, replayed motion; addresses."""

import contextlib
import os
import pathlib
import resource
import subprocess
import time

from daemon import FINGER, PROGRAM, Daemon, resident

MB = 1 << 20


def run(arguments, seconds=10.0, folder=None, address_space=1 << 30):
    """A hapticd that should end by itself: (status, its words, seconds); status None: it was still
    running, and SIGTERM ended it."""
    began = time.monotonic()

    def prepare():
        resource.setrlimit(resource.RLIMIT_AS, (address_space,) * 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    process = subprocess.Popen([PROGRAM, *arguments], stdin=subprocess.DEVNULL, cwd=folder,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               preexec_fn=prepare)
    try:
        words, _ = process.communicate(timeout=seconds)
        return process.returncode, words.decode(errors="replace"), time.monotonic() - began
    except subprocess.TimeoutExpired:
        process.terminate()
        try:
            words, _ = process.communicate(timeout=5.0)
            return None, words.decode(errors="replace"), time.monotonic() - began
        except subprocess.TimeoutExpired:
            process.kill()
            words, _ = process.communicate()
            return "deaf", "no end after SIGTERM", time.monotonic() - began


def replays(folder):
    """Recordings that cannot be played, and CSV bombs: refused with file and line, in time and
    within memory."""
    head = b"time_s,q_o1_mcp_rad,q_o2_pip_rad\n"
    good = b"".join(b"%d.%02d,0.1,0.2\n" % divmod(i, 100) for i in range(200))
    files = {
        "empty": b"", "header": head, "one row": head + b"0,0,0\n",
        "nan": head + b"0,nan,0\n1,0,0\n", "inf": head + b"0,inf,0\n1,0,0\n",
        "text": head + b"0,x,0\n1,0,0\n", "huge": head + b"0,1e308,0\n1,-1e308,0\n",
        "back": head + b"1,0,0\n0,0,0\n", "same": head + b"0,0,0\n0,0,0\n",
        "short row": head + b"0,0\n1,0,0\n", "long row": head + b"0,0,0,0\n1,0,0\n",
        "no time": b"q_o1_mcp_rad,q_o2_pip_rad\n0,0\n", "twice": head.replace(b"q_o2", b"q_o1") +
        b"0,0,0\n1,0,0\n", "other columns": b"time_s,a,b\n0,0,0\n1,0,0\n",
        "nul": head + b"\0" * 1_000, "binary": os.urandom(20_000), "utf16": head.decode().encode(
            "utf-16") + good, "quotes": head + b'"' * 50_000, "tiny step": head +
        b"0,0,0\n5e-324,1,0\n", "negative zero": head + b"-0,0,0\n0,0,0\n",
        "long line": head + b"1" * (4 * MB) + b"\n", "many columns": b"time_s" + b",a" * 300_000 +
        b"\n0" + b",0" * 300_000 + b"\n", "many rows": head + b"\n" * (3 * MB),
        "overflow": head + b"0,1e999,0\n1,0,0\n", "hex": head + b"0,0x10,0\n1,0,0\n",
        "comma": head + b"0;0;0\n1;0;0\n",
    }
    wrong, slow = [], 0.0
    for name, data in files.items():
        file = pathlib.Path(folder) / "motion.csv"
        file.write_bytes(data)
        scene = pathlib.Path(folder) / "replay.textproto"
        scene.write_text('name: "replay"\n' + replay_device(file))
        status, words, took = run(["--scene", scene, "--check-scene"], 10.0)
        slow = max(slow, took)
        if status not in (0, 1, 2):
            wrong.append(f"{name}: status {status}: {words[-80:]}")
        elif took > 5.0:
            wrong.append(f"{name}: {took:.1f} s")
        elif status == 0 and name not in ("negative zero", "many rows", "tiny step", "huge",
                                          "hex", "quotes", "long row"):
            wrong.append(f"{name}: accepted")
        elif status and not words.strip():
            wrong.append(f"{name}: refused without a word")
    return {"wrong": wrong, "notes": [f"{len(files)} files, {slow:.1f} s at most"]}


def replay_device(file):
    return (f'device {{ name: "finger" replay {{ file: "{file}" max_effort: 40 }} '
            'finger_exoskeleton {} impedance { stiffness_n_per_m: 1500 } '
            'limits { force_n: 20 } }\n')


def replay_span(folder):
    """A recording that is longer than a clock of nanoseconds: refused, or it plays; never "ok" and
    then INIT for ever."""
    wrong = []
    for first, last in (("0", "9.3e9"), ("-8e9", "8e9"), ("0", "1e300"), ("-1e19", "0")):
        file = pathlib.Path(folder) / "span.csv"
        file.write_text("time_s,q_o1_mcp_rad,q_o2_pip_rad\n" +
                        f"{first},0.3,0.3\n{last},0.3,0.3\n")
        daemon = Daemon(f"{folder}/{last}", devices=replay_device(file), wait=False, record=False)
        with contextlib.suppress(RuntimeError):
            daemon.wait_served(4.0)
        if daemon.process.poll() is None:
            time.sleep(0.5)
            log = daemon.text()
            if "INIT -> IDLE" not in log:
                wrong.append(f"{first}..{last} s: served, INIT for ever")
        elif daemon.process.returncode not in (1, 2):
            wrong.append(f"{first}..{last} s: status {daemon.process.returncode}")
        daemon.stop()
    return {"wrong": wrong}


def scenes(folder):
    """Scenes and overrides that are wrong: refused by name, in time; none crashes."""
    base = 'name: "a"\n' + FINGER
    force = "limits { force_n: 25 slew_n_per_s: 2500 }"
    texts = {
        "empty": "", "no device": 'name: "a"\n', "no name": FINGER, "junk": "\x01\x02{{{",
        "unclosed": base[:-3], "two": base + FINGER, "nul": base + "\0",
        "long name": 'name: "' + "x" * 100_000 + '"\n' + FINGER, "newline": base.replace(
            '"a"', '"a\\nb"'), "deep": "device { " * 5_000,
        "force nan": base.replace("force_n: 25", "force_n: nan"),
        "force inf": base.replace("force_n: 25", "force_n: inf"),
        "force 41": base.replace("force_n: 25", "force_n: 41"),
        "force -1": base.replace("force_n: 25", "force_n: -1"),
        "two forces": base.replace("force_n: 25", "force_n: [25, 25]"),
        "many forces": base.replace("force_n: 25", "force_n: [" + "25, " * 50_000 + "25]"),
        "no limits": base.replace(force, ""),
        "slew 0": base.replace("2500", "0"), "stiffness 1e308": base.replace("1500", "1e308"),
        "stiffness 0": base.replace("1500", "0"),
        "lease": base + "server { lease_timeout { seconds: 9223372036854775807 } }",
        "period 0": base + "loop { period { nanos: 0 } }",
        "period -": base + "loop { period { seconds: -1 } }",
        "priority": base + "loop { priority: 2147483647 }", "cpu": base + "loop { cpu: 1024 }",
        "sessions": base + "server { max_sessions: 4294967295 }",
        "listen": base + 'server { listen: "nonsense" }',
        "record": base + 'record { file: "/no/such/folder/run.csv" }',
        "record txt": base + 'record { file: "run.txt" }',
        "motion": base.replace("target_mcp_rad: 0.5236", 'motion_file: "/no/such"'),
        "bad utf-8": base.replace('"a"', '"\\xff\\xfe"'), "escape": base.replace(
            '"a"', '"\\033[31m"'), "device name": base.replace('"finger"', '"../../finger"'),
        "unknown": base + "unknown: 1", "staleness": base.replace(
            "direction_guard {}", "staleness { fade_end { seconds: 100 } }"),
        "W": base.replace("direction_guard {}", "metric { W: [1, 2, 3] }"),
        "hold": base.replace("direction_guard {}", "staleness { hold_end { nanos: -1 } }"),
    }
    overrides = ["a", "=", "a=", "=1", "device[99].name=x", "device[-1].name=x",
                 "device[99999999999999999999].name=x", "loop.priority=99", "loop={", "loop=}",
                 "device[0].limits.force_n[7]=1", "server.listen[1000000]=x", "loop.period=1",
                 "name=" + "x" * 100_000, "device.name=x", ".=1", "device[0]=", "name[0]=x"]
    wrong, slow = [], 0.0
    file = pathlib.Path(folder) / "scene.textproto"

    def judge(name, arguments):
        nonlocal slow
        status, words, took = run(["--scene", file, *arguments, "--check-scene"], 10.0)
        slow = max(slow, took)
        if status not in (1, 2) or not words.strip():
            wrong.append(f"{name}: status {status}: {words[-60:]}")
        elif took > 5.0:
            wrong.append(f"{name}: {took:.1f} s")
        elif any(ord(c) < 32 and c != "\n" for c in words):
            wrong.append(f"{name}: control characters in the message")
    may_load = ("stiffness 1e308", "bad utf-8", "record", "cpu", "sessions")
    for name, text in texts.items():
        file.write_text(text)
        if name in may_load:
            status, words, took = run(["--scene", file, "--check-scene"], 10.0)
            if status not in (0, 1, 2) or took > 5.0:
                wrong.append(f"{name}: status {status} after {took:.1f} s")
        else:
            judge(name, [])
    file.write_text(base)
    for override in overrides:
        judge(f"--set {override[:30]}", ["--set", override])
    return {"wrong": wrong[:8], "notes": [f"{len(texts) + len(overrides)} scenes, "
                                          f"{slow:.1f} s at most"]}


def big_scenes(folder):
    """A scene of 3 GB (sparse, so that it costs no disk), and one of 150,000 unknown fields:
    refused within 5 s, SIGTERM heard, little memory."""
    wrong, notes = [], []
    file = pathlib.Path(folder) / "big.textproto"
    base = 'name: "a"\n' + FINGER
    file.write_text(base)
    os.truncate(file, 3 << 30)
    began = time.monotonic()
    process = subprocess.Popen([PROGRAM, "--scene", file, "--check-scene"],
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL,
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS,
                                                                     (1 << 29, 1 << 29)))
    most = 0
    while process.poll() is None and time.monotonic() < began + 5.0:
        most = max(most, resident(process.pid))
        time.sleep(0.005)
    took = time.monotonic() - began
    process.kill()
    status = process.wait()
    notes.append(f"3 GB: status {status}, {most / MB:.0f} MB, {took:.1f} s")
    if most > 100 * MB or status not in (1, 2):
        wrong.append(f"3 GB: status {status}, {most / MB:.0f} MB resident")
    file.unlink()
    file.write_text(base + "".join(f"unknown_{i}: 1\n" for i in range(150_000)))
    status, _, took = run(["--scene", file], 3.0)
    notes.append(f"unknown fields: status {status}, {took:.1f} s")
    if status not in (1, 2):
        wrong.append(f"150,000 unknown fields: status {status} after {took:.1f} s")
    return {"wrong": wrong, "notes": notes}


def addresses(folder):
    """Addresses to listen at that are wrong, or of others: refused with a word."""
    wrong = []
    scene = pathlib.Path(folder) / "scene.textproto"
    scene.write_text('name: "a"\n' + FINGER)
    for address in ("", ":", ":0", "127.0.0.1", "127.0.0.1:", "127.0.0.1:-1", "127.0.0.1:65536",
                    "127.0.0.1:99999999999999", "127.0.0.1:x", "0.0.0.0:0", "[::]:0", "8.8.8.8:0",
                    "[::1", "unix:", "unix:relative", "unix:/no/such/folder/s",
                    "unix:/" + "x" * 200, "unix:/dev/null", "http://127.0.0.1:0", "127.0.0.1:0 ",
                    "no.such.host.invalid:0", "\x1b[31m:0", "x" * 100_000 + ":0"):
        status, words, took = run(["--scene", scene, "--listen", address], 4.0)
        if status not in (1, 2) or not words.strip():
            wrong.append(f"'{address[:24]}': status {status}: {words[-60:]}")
    return {"wrong": wrong}
