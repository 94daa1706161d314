"""More attacks from outside, by mechanism: how hapticd is started, what its host refuses, files
that wait, programs that are no fronts, and stops that others lead astray."""

import contextlib
import fcntl
import os
import pathlib
import pty
import resource
import signal
import socket
import subprocess
import sys
import termios
import threading
import time

import inside
from daemon import (CONTROL, FINGER, MB, PROGRAM, Controller, Daemon, control, descendants,
                    free_port, local_stop)
from faults import until_served
from files import replay_device, run
from frames import served
from judge import TERM_S, judge_ticks, read_record
from neighbours import as_user, control_path, kill_fronts
from outside import parts
from signals import dirty

USER = 60_123
PIPE_SIZE = 1031  # F_SETPIPE_SZ


def ended(daemon, name=""):
    """What was wrong with the end after SIGTERM."""
    took, status = daemon.stop()
    return [] if took <= TERM_S and status == 0 else [f"{name}SIGTERM: {status} after {took:.1f} s"]


def replaced(daemon, name="", seconds=1.0):
    """What was wrong with the front after one that was killed."""
    kill_fronts(daemon)
    took = until_served(daemon)
    return [] if took is not None and took <= seconds else [f"{name}served again after {took} s"]


def stopped(daemon, times=20):
    """Local stops that were not answered."""
    wrong = []
    for _ in range(times):
        try:
            local_stop(daemon)
        except OSError as why:
            wrong.append(f"local stop: {why}")
    return wrong[:1]


def children_ignored(folder):
    """Started by a program that ignores SIGCHLD, as shells and services may."""
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    daemon = Daemon(folder, record=False)
    signal.signal(signal.SIGCHLD, before)
    return {"wrong": replaced(daemon) + replaced(daemon) + ended(daemon)}


def signals_blocked(folder):
    """Started with every signal blocked and ignored."""
    every = signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}
    before = {number: signal.signal(number, signal.SIG_IGN) for number in every}
    signal.pthread_sigmask(signal.SIG_BLOCK, every)
    try:
        daemon = Daemon(folder, record=False)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler or signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, every)
    return {"wrong": replaced(daemon) + ended(daemon)}


def deaf_manager(folder):
    """A service manager that hangs: its socket is full. SIGTERM is heard, and force fades."""
    place = f"{folder}.notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager, \
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        manager.bind(place)
        daemon = Daemon(folder, env={"NOTIFY_SOCKET": place, "WATCHDOG_USEC": "200000"})
        other.setblocking(False)
        with contextlib.suppress(OSError):
            while True:
                other.sendto(b"x", place)
        controller = Controller(daemon.address)
        wrong = ["no force"] if controller.engaged_within(8.0) is None else []
        wrong += ended(daemon)
        controller.kill()
    force, faults = judge_ticks(read_record(daemon.record))
    return {"wrong": wrong + ([force] if force else []) + faults}


def deaf_log(folder):
    """Standard error is a pipe, then a terminal after Ctrl-S, and nobody reads."""
    wrong = []
    for name, (here, there) in (("pipe", os.pipe()), ("terminal", pty.openpty())):
        if name == "pipe":
            fcntl.fcntl(there, PIPE_SIZE, 4096)
        else:
            termios.tcflow(there, termios.TCOOFF)
        daemon = Daemon(f"{folder}/{name}", record=False, stdout=there, stderr=there)
        for _ in range(40 if name == "pipe" else 1):
            wrong += stopped(daemon, 1)
            control(daemon, "--device", "spare", "clear-fault")
        wrong += replaced(daemon, name + ": ") + ended(daemon, name + ": ")
        if name == "terminal":
            termios.tcflow(there, termios.TCOON)
        os.close(here)
        os.close(there)
    return {"wrong": wrong}


def inherited_files(folder):
    """Two hundred descriptors of the program that starts it, secret and writable: no front has
    one."""
    secret = f"{folder}.secret"
    held = [os.open(secret, os.O_RDWR | os.O_CREAT) for _ in range(200)]
    daemon = Daemon(folder, record=False, pass_fds=held)
    links = [os.readlink(f"/proc/{pid}/fd/{one}") for pid in daemon.fronts()
             for one in os.listdir(f"/proc/{pid}/fd")]
    for one in held:
        os.close(one)
    return {"wrong": (["a front has one"] if secret in links or not links else []) + ended(daemon)}


def file_masks(folder):
    """umask 0 and 0777: the control socket is neither everyone's, nor shut to its owner."""
    wrong = []
    for mask in (0, 0o777):
        daemon = Daemon(f"{folder}/{mask:o}", umask=mask, record=False)
        mode = os.stat(control_path(daemon)).st_mode & 0o777
        if mode & 0o077:
            wrong.append(f"umask {mask:o}: the control socket has mode {mode:o}")
        wrong += stopped(daemon, 1) + replaced(daemon) + ended(daemon)
    return {"wrong": wrong}


def other_clock(folder):
    """In a time namespace, a hundred years after the host began: force, and the local stop."""
    daemon = Daemon(folder, wait=False, prefix=(
        "unshare", "--time", "--monotonic", "3000000000", "--boottime", "3000000000", "--fork",
        "--kill-child"))
    with contextlib.suppress(RuntimeError):
        daemon.wait_served(5.0)
    if daemon.process.poll() is not None:
        return {"notes": ["not on this host: no time namespace"]}
    controller = Controller(daemon.address)
    wrong = ["no force"] if controller.engaged_within(8.0) is None else []
    local_stop(daemon, "finger")
    for pid, name in descendants(daemon.pid).items():
        if name == "hapticd":
            os.kill(pid, signal.SIGTERM)
    daemon.process.wait(10.0)
    controller.kill()
    force, faults = judge_ticks(read_record(daemon.record), ("EMERGENCY_STOP",))
    return {"wrong": wrong + ([force] if force else []) + faults}


def bare_hosts(folder):
    """Without /proc, without /dev, with a /run that is full or may not be written: served, or
    refused in words within 8 s."""
    wrong, notes = [], []
    for name, mount in (("no /proc", "mount -t tmpfs none /proc"),
                        ("no /dev", "mount -t tmpfs none /dev"),
                        ("/run read-only", "mount -t tmpfs -o ro none /run"),
                        ("/run full", "mount -t tmpfs -o nr_inodes=1 none /run")):
        daemon = Daemon(f"{folder}/{len(notes)}", record=False, wait=False, prefix=(
            "unshare", "-m", "sh", "-c", f"{mount}; exec \"$0\" \"$@\""))
        with contextlib.suppress(RuntimeError):
            daemon.wait_served(8.0)
        if daemon.process.returncode is None:
            notes.append(f"{name}: serves")
            wrong += replaced(daemon, name + ": ", 2.0) + ended(daemon, name + ": ")
        else:
            status, words = daemon.process.returncode, daemon.text().strip()
            notes.append(f"{name}: {status}, {words[-60:]}")
            if status not in (1, 2) or not words:
                wrong.append(f"{name}: ended with {status}: {words[-90:]}")
    return {"wrong": wrong, "notes": notes}


def no_more_processes(folder):
    """The host grants no process when a front dies: said as it is, and served once it does."""
    daemon = Daemon(folder, record=False, user=USER)
    launcher = next(p for p, n in descendants(daemon.pid).items() if n.startswith("hapticd-launch"))
    before = resource.getrlimit(resource.RLIMIT_NPROC)

    def grant(most):
        as_user(USER, lambda: [resource.prlimit(launcher, resource.RLIMIT_NPROC,
                                                (most, before[1]))])
    grant(1)
    kill_fronts(daemon)
    time.sleep(0.8)
    wrong = ["the row did not run: a front was started"] if served(daemon.tcp, 0.3) else []
    wrong += stopped(daemon)
    log = daemon.text()
    if "SIGSEGV" in log or "cannot be started" not in log:
        wrong.append("the log does not say why: " + log.strip()[-100:])
    grant(before[0])
    took = until_served(daemon)
    if took is None or took > 2.5:
        wrong.append(f"served again after {took} s")
    return {"wrong": wrong + ended(daemon)}


def full_groups(folder):
    """Control groups that are full: no new process; no memory, by a neighbour in the same one; a
    fiftieth of a processor for the front. The owner lives and answers, and it is served again."""
    wrong, notes = [], []
    for kind, file, tight, loose in (("pids", "pids.max", "1", "max"),
                                     ("memory", "memory.limit_in_bytes", str(300 * MB), "-1"),
                                     ("cpu", "cpu.cfs_quota_us", "2000", "-1")):
        group = pathlib.Path(f"/sys/fs/cgroup/{kind}/haptic-{os.getpid()}")
        try:
            group.mkdir()
        except OSError:
            notes.append(f"not on this host: no cgroup of {kind}")
            continue
        daemon, eater = Daemon(f"{folder}/{kind}", record=False), None
        try:
            for pid in daemon.fronts() if kind == "cpu" else descendants(daemon.pid):
                (group / "cgroup.procs").write_text(str(pid))
            (group / file).write_text(tight)
            if kind == "memory":
                eater = subprocess.Popen(
                    [sys.executable, "-c", "import time; time.sleep(0.5)\nx = []\n"
                     "while len(x) < 500: x.append(bytearray(1 << 20)); time.sleep(0.002)"],
                    stderr=subprocess.DEVNULL)
                (group / "cgroup.procs").write_text(str(eater.pid))
            if kind == "pids":
                kill_fronts(daemon)
            time.sleep(2.0)
            wrong += [f"{kind}: {words}" for words in stopped(daemon)]
            if daemon.process.poll() is not None:
                wrong.append(f"{kind}: hapticd died")
            (group / file).write_text(loose)
            if until_served(daemon) is None:
                wrong.append(f"{kind}: not served again")
        finally:
            (group / file).write_text(loose)
            if eater:
                eater.kill()
                eater.wait()
            wrong += ended(daemon, f"{kind}: ")
            group.rmdir()
    return {"wrong": wrong, "notes": notes}


TLS = 'server {{ tls {{ certificate: "{}" key: "{}" client_ca: "{}" }} }}\n'
SCENES = {  # a file that a scene names, by its field, next to a good certificate and key
    "certificate": lambda f, pem, key: FINGER + TLS.format(f, key, pem),
    "key": lambda f, pem, key: FINGER + TLS.format(pem, f, pem),
    "client_ca": lambda f, pem, key: FINGER + TLS.format(pem, key, f),
    "token": lambda f, pem, key: FINGER + f'server {{ web {{ token {{ name: "a" file: "{f}" '
                                          'rights: "observe" } } }\n',
    "motion_file": lambda f, pem, key: FINGER.replace(
        "target_mcp_rad: 0.5236 target_pip_rad: 0.5236", f'motion_file: "{f}"'),
    "file": lambda f, pem, key: replay_device(f),
    "calibration_file": lambda f, pem, key: 'device { name: "b" board { port: "/dev/null" '
                                            f'max_effort: 4 calibration_file: "{f}" }} '
                                            'finger_exoskeleton {} limits { force_n: 2 } '
                                            'impedance { stiffness_n_per_m: 9 } }\n'}


def odd_files(folder):
    """Every file that a scene names, and the scene, as a pipe, a folder, an endless device, 3 GB, a
    circle of links, and one on whose opening another waits: refused by name within 5 s."""
    from certificates import certificate
    place, wrong = pathlib.Path(folder), []
    certificate(folder, "a")
    os.mkfifo(place / "fifo")
    (place / "folder").mkdir()
    (place / "huge").touch()
    os.truncate(place / "huge", 3 << 30)
    (place / "circle").symlink_to(place / "circle")
    lease = os.open(place / "leased", os.O_RDWR | os.O_CREAT, 0o600)
    for name in ("a.key", "huge"):
        os.chmod(place / name, 0o600)
    signal.signal(signal.SIGIO, signal.SIG_IGN)
    fcntl.fcntl(lease, fcntl.F_SETLEASE, fcntl.F_WRLCK)
    scene = place / "scene.textproto"
    for name in ("fifo", "folder", "huge", "circle", "leased", "/dev/zero", "/dev/ptmx",
                 "/proc/self/mem"):
        file = place / name
        for field, text in SCENES.items():
            scene.write_text('name: "a"\n' + text(file, place / "a.pem", place / "a.key"))
            status, words, took = run(["--scene", scene, "--check-scene"], 6.0)
            if status not in (1, 2) or took > 5.0 or not (field in words or str(file) in words):
                wrong.append(f"{field} as {name}: {status} after {took:.1f} s: {words[-70:]}")
        status, words, took = run(["--scene", file, "--check-scene"], 6.0)
        if status not in (1, 2) or took > 5.0:
            wrong.append(f"scene as {name}: {status} after {took:.1f} s")
    os.close(lease)
    return {"wrong": wrong[:5], "notes": [f"{8 * len(SCENES) + 8}"]}


NO_FRONTS = {"missing": None, "no program": "", "ends": "exit 0", "dies": "kill -9 $$",
             "junk": "head -c 3000 /dev/urandom >&3; sleep 60", "many": "while :; do echo x >&3; "
             "done", "silent": "while :; do printf '\\033[2Jforged\\n' >&2; sleep 0.001; done"}


def no_fronts(folder):
    """The front's program is replaced by others, then one is asked for: refused in words while the
    old one serves; and with the right one again it is replaced."""
    real = pathlib.Path(PROGRAM).parent / "hapticd-front"
    program, wrong = pathlib.Path(f"{folder}/hapticd-front"), []
    program.symlink_to(real)
    daemon = Daemon(f"{folder}/run", record=False, env={"HAPTICD_FRONT": str(program)})
    before = set(daemon.fronts())
    for name, text in NO_FRONTS.items():
        program.unlink(missing_ok=True)
        if text is not None:
            program.write_text("#!/bin/sh\n" + text)
            program.chmod(0o644 if name == "no program" else 0o755)
        _, status, words = control(daemon, "restart-front", timeout=15.0)
        if status == 0 or "refused" not in words:
            wrong.append(f"{name}: {status} {words[-60:]}")
        if not before <= set(daemon.fronts()) or not served(daemon.tcp, 1.0):
            wrong.append(f"{name}: the old front left")
    program.unlink()
    program.symlink_to(real)
    if control(daemon, "restart-front", timeout=15.0)[1] != 0:
        wrong.append("the right one is refused")
    wrong += ended(daemon)
    found = dirty(daemon.log.read_bytes())
    return {"wrong": wrong + ([f"in the log: {' '.join(sorted(found))}"] if found else [])}


def restart_storm(folder):
    """Restarts by three at once, SIGHUP, and fronts that are killed, while local stops come: each
    is answered and stays, and it is served in the end."""
    place = f"{folder}.notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(place)
        daemon = Daemon(folder, env={"NOTIFY_SOCKET": place})
        until, wrong, stops = time.monotonic() + 4.0, [], 0

        def restart():
            while time.monotonic() < until:
                control(daemon, "restart-front", timeout=15.0)

        def kill():
            while time.monotonic() < until:
                time.sleep(0.7)
                kill_fronts(daemon)
                daemon.process.send_signal(signal.SIGHUP)
        threads = [threading.Thread(target=work) for work in (restart, restart, restart, kill)]
        for thread in threads:
            thread.start()
        while time.monotonic() < until:
            wrong += stopped(daemon, 1)
            stops += 1
            time.sleep(0.01)
        for thread in threads:
            thread.join()
        if until_served(daemon) is None:
            wrong.append("not served in the end")
        wrong += inside.stays_stopped(daemon, ()) + ended(daemon)
    return {"wrong": wrong[:4], "notes": [f"{stops} stops"]}


def estop(port, host="127.0.0.1", reason="x"):
    done = subprocess.run([CONTROL, "--server", f"{host}:{port}", "--device", "spare", "estop",
                           "--reason", reason], capture_output=True, text=True, timeout=15.0)
    return done.stdout + done.stderr


def led_astray(folder):
    """An operator's stop, with another program on [::1] of the same port; with a reason that is
    long; and where a user's link leads to another hapticd's control socket."""
    daemon, wrong = Daemon(folder, record=False), []
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET6) as impostor:
        impostor.bind(("::1", daemon.port))
        impostor.listen(64)
        said = estop(daemon.port, "localhost")
        if "stopped locally: spare" not in said:
            wrong.append(f"with another on [::1]: {said}")
    said = estop(daemon.port, reason="long " * 200)
    if "stopped locally: spare" not in said:
        wrong.append(f"with a long reason: {said}")
    place, port = pathlib.Path(f"/run/user/{USER}/hapticd"), free_port(socket.SOCK_STREAM)
    place.mkdir(parents=True, exist_ok=True)
    for one in (place, place.parent):
        os.chown(one, USER, USER)
    (place / f"127.0.0.1:{port}").symlink_to(control_path(daemon))
    said = estop(port)
    if "stopped" in said:
        wrong.append(f"by a user's link: {said}")
    (place / f"127.0.0.1:{port}").unlink()
    place.rmdir()
    place.parent.rmdir()
    return {"wrong": wrong + ended(daemon)}


def row(name, expected, *attacks):
    return (name, expected, parts(*attacks, root=True), {"alone": True, "seconds": 90.0})


ROWS = [row("outside_starts", "served, ends in 5 s", children_ignored, signals_blocked,
            deaf_manager, deaf_log, inherited_files, file_masks, other_clock),
        row("outside_hosts", "served, or refused with a word", bare_hosts, no_more_processes,
            full_groups),
        row("outside_files", "refused by name", odd_files),
        row("outside_fronts", "the old one stays, stops too", no_fronts, restart_storm),
        row("outside_tools", "stopped locally", led_astray)]
