"""Attacks from inside the front whose daemons are of their own (inside.py)."""

import contextlib
import os
import pathlib
import pty
import select
import signal
import socket
import time

from daemon import Controller, Daemon, control, descendants, fronts_of, local_stop
from faults import until_served
from frames import served
from inside import MODES, Attacker, clean_log, environment, summary, words_of
from judge import TERM_S, judge_ticks, read_record
from signals import dirty

STOPPED_S = 0.010  # from the answer to a local stop until there is no force


def ends_late(daemon):
    """SIGTERM must end it in time, with status 0."""
    took, status = daemon.stop()
    if took <= TERM_S and status == 0:
        return []
    return [f"SIGTERM: status {status} after {took:.1f} s"]


def plays(folder, *commands):
    """The attacker plays the client that died. That is allowed within the limits; a local stop ends
    it, whatever else it does, and SIGTERM ends hapticd."""
    daemon = Daemon(folder, env=environment(folder))
    controller = Controller(daemon.address)
    wrong, notes = [], []
    try:
        if controller.engaged_within(20.0) is None:
            return {"wrong": ["no force before the attack"]}
        time.sleep(0.7)
        attacker = Attacker(daemon)
        for command in commands:
            mode, *words = command.split()
            attacker.tell(mode, 30.0, *words)
            time.sleep(0.2)
        controller.kill()
        died = time.monotonic()
        time.sleep(2.0)
        health = control(daemon, "health")[2]
        if "warn" not in health.lower():
            wrong.append(f"hapticctl health does not warn: {health!r}")
        asked = time.monotonic()
        try:
            notes.append(f"stop {1e3 * local_stop(daemon, 'finger'):.1f} ms")
        except OSError as why:
            wrong.append(f"local stop: {why}")
        time.sleep(2.0)
        wrong += ends_late(daemon)
    finally:
        controller.kill()
        daemon.kill()
    ticks = read_record(daemon.record)
    force, faults = judge_ticks(ticks, ("EMERGENCY_STOP",))
    pressed = [t.at * 1e-9 for t in ticks if t.tau and t.at * 1e-9 > died]
    notes.append(f"force {max(pressed, default=died) - died:.2f} s after the client's death")
    late = [at for at in pressed if at > asked + STOPPED_S]
    if late:
        wrong.append(f"force until {late[-1] - asked:.3f} s after a local stop")
    return {"wrong": wrong + ([force] if force else []) + faults, "notes": notes}


def plays_client(folder):
    return plays(folder, "pretend alone clears")


def plays_client_blocking(folder):
    return plays(folder, "blocking deaf", "pretend alone clears")


def terminal(folder):
    """hapticd in a terminal, into which the front would type (TIOCSTI)."""
    keys = pathlib.Path("/proc/sys/dev/tty/legacy_tiocsti")
    if keys.exists() and keys.read_text().strip() == "0":
        return {"notes": ["not on this host: dev.tty.legacy_tiocsti is 0"]}
    here, there = pty.openpty()
    daemon = Daemon(folder, env=environment(folder), record=False, stdin=there, stdout=there,
                    stderr=there, prefix=("setsid", "--ctty"))
    try:
        answer = MODES[0](daemon)
    finally:
        daemon.stop()
    os.set_blocking(there, False)
    with contextlib.suppress(OSError):
        answer["wrong"].append(f"typed {os.read(there, 100)!r}")
    os.close(here)
    os.close(there)
    return answer


def launcher_stopped(folder):
    """The launcher stands still, then the front dies: stops and SIGTERM go on, and it is said."""
    daemon = Daemon(folder, record=False)
    launcher = words_of(daemon)["%launcher"]
    wrong = []
    try:
        os.kill(launcher, signal.SIGSTOP)
        for pid in fronts_of(daemon.pid):
            os.kill(pid, signal.SIGKILL)
        time.sleep(4.0)
        if "launcher" not in daemon.text():
            wrong.append("the log does not name the launcher")
        try:
            local_stop(daemon)
        except OSError as why:
            wrong.append(f"local stop: {why}")
        took, status = daemon.stop()
        if took > TERM_S:
            wrong.append(f"SIGTERM took {took:.1f} s, status {status}")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(launcher, signal.SIGKILL)
        daemon.kill()
    return {"wrong": wrong}


STARTS = ("ready early", "ready refuses", "ready dies exit", "go early", "go refuses",
          "go dies abort", "go dies hang")


def starts(folder):
    """The next front attacks before it serves. One that is not ready leaves the old one where it
    is, and one that does not serve is followed by others until one does."""
    daemon, wrong, notes = Daemon(folder, env=environment(folder)), [], []
    controller = Controller(daemon.address)
    try:
        if controller.engaged_within(20.0) is None:
            return {"wrong": ["no force before the attack"]}
        for start in STARTS:
            stage, *mode = start.split()
            file, before = daemon.folder / "front" / "start", daemon.fronts()
            file.write_text(f"{stage} {mode[0]} 0.5 {' '.join(mode[1:])}")
            last = start == STARTS[-1]
            _, status, words = control(daemon, "restart-front", timeout=1.0 if last else 15.0)
            kept = stage == "ready" and mode[0] != "early"
            if kept and (status == 0 or daemon.fronts() != before):
                wrong.append(f"{start}: the old front is gone: {words!r}")
            if dirty(words.encode().replace(b"\t", b"")):
                wrong.append(f"{start}: {words!r}")
            local_stop(daemon)
            if last:
                break  # SIGTERM comes while it hangs
            time.sleep(1.0)  # others follow, and end as well
            file.unlink()
            took = until_served(daemon)
            notes.append(f"{start}: {'never' if took is None else f'{took:.1f} s'}")
            if took is None or controller.engaged_within(5.0) is None:
                wrong.append(f"{start}: not served, or no force again")
        wrong += ends_late(daemon)
    finally:
        controller.kill()
        daemon.kill()
    force, faults = judge_ticks(read_record(daemon.record))
    return {"wrong": wrong + clean_log(daemon, []) + ([force] if force else []) + faults,
            "notes": notes}


def bequeaths(folder):
    """A front that leaves in order changed the sockets that the next one gets, and a user of this
    host has copies of them: no caller comes to him."""
    daemon, wrong = Daemon(folder, env=environment(folder), record=False), []
    try:
        with socket.socket(socket.AF_UNIX) as friend:
            friend.connect(daemon.unix)
            time.sleep(0.2)
            attacker = Attacker(daemon)
            attacker.tell("bequeaths", 1.0)
            notes = [summary(attacker.hear(5.0))]
            friend.settimeout(1.0)
            copies = []
            while not copies:  # greetings of the front come first
                _, copies, *_ = socket.recv_fds(friend, 4096, 60)
            copies = [socket.socket(fileno=fd) for fd in copies]
            _, status, words = control(daemon, "restart-front", timeout=15.0)
            if status != 0 or not copies:
                wrong.append(f"{len(copies)} copies, restart-front: {words!r}")
            for _ in range(20):
                if not (served(daemon.tcp, 1.0) and served(daemon.unix, 1.0)):
                    wrong.append("not served")
                for copy in copies:
                    copy.setblocking(False)
                    with contextlib.suppress(OSError):
                        copy.accept()
                        wrong.append(f"a caller came to a copy: {copy.getsockname()}")
            for copy in copies:
                looks = select.poll()
                looks.register(copy, select.POLLRDHUP)
                if not looks.poll(0):
                    wrong.append(f"a copy lives on: {copy.getsockname()}")
                copy.close()
    finally:
        daemon.stop()
    return {"wrong": wrong, "notes": notes}


def orphans(folder):
    """The first thread of the front has ended, and the owner is killed: nothing is left."""
    daemon, wrong = Daemon(folder, env=environment(folder), record=False), []
    family = [pid for pid in descendants(daemon.pid) if pid != daemon.pid]
    Attacker(daemon).tell("zombie", 30.0)
    time.sleep(0.5)
    daemon.process.kill()
    daemon.process.wait()
    time.sleep(1.0)
    for pid in family:
        with contextlib.suppress(OSError):
            name = pathlib.Path(f"/proc/{pid}/stat").read_text().split(")")
            if not name[1].startswith(" Z"):
                wrong.append(f"{pid} {name[0]} lives on")
                os.kill(pid, signal.SIGKILL)
    return {"wrong": wrong, "notes": [f"{len(family)} processes"]}


ALONE = [("plays_client", "F1", "within limits; a local stop ends it", plays_client),
         ("plays_client_blocking", "F1", "within limits; a local stop ends it",
          plays_client_blocking),
         ("starts", "second", "the old one stays, or another follows", starts),
         ("bequeaths", "second", "no caller comes to a copy", bequeaths),
         ("orphans", "second", "no process is left", orphans),
         ("terminal", "F3", "nothing is typed", terminal),
         ("launcher_stopped", "F12", "said; stops and SIGTERM as always", launcher_stopped)]
