"""Connections: too many, or silent."""

import contextlib
import os
import resource
import select
import signal
import time

from daemon import Daemon, control
from frames import (END_HEADERS, HEADERS, PREFACE, SERVICE, SETTINGS, call, connect, frame, served)


def fill(address, count):
    """So many idle connections, as far as the server takes them."""
    held = []
    with contextlib.suppress(OSError):
        for _ in range(count):
            held.append(connect(address, timeout=0.5))
    return held


def exhaust(daemon, address):
    """All descriptors that the process may have, for a moment; then all are closed."""
    held = fill(address, 1_500)
    time.sleep(1.5)
    during = served(daemon.tcp, 1.0)
    for end in held:
        end.close()
    return {"notes": [f"{len(held)} connections", f"served meanwhile: {during}"]}


def exhaust_tcp(daemon):
    return exhaust(daemon, daemon.tcp)


def exhaust_unix(daemon):
    return exhaust(daemon, daemon.unix)


def silent(daemon):
    """No bytes, the preface alone, silence after SETTINGS, half a frame: closed within 35 s."""
    begun = [b"", PREFACE, PREFACE + frame(SETTINGS, 0, 0),
             PREFACE + frame(SETTINGS, 0, 0) +
             frame(HEADERS, END_HEADERS, 1, call(SERVICE + "GetServerInfo"))[:40]]
    waiting = {}
    for words in begun:
        for _ in range(10):
            end = connect(daemon.tcp)
            end.sendall(words)
            waiting[end] = len(words)
    sent, wrong, began = sum(waiting.values()), [], time.monotonic()
    while waiting and time.monotonic() < began + 45.0:
        for end in select.select(list(waiting), [], [], 1.0)[0]:
            try:
                gone = not end.recv(1 << 16)
            except OSError:
                gone = True
            if gone:
                del waiting[end]
    if waiting:
        wrong.append(f"{len(waiting)} silent connections open after 45 s, "
                     f"which had sent {sorted(set(waiting.values()))} bytes")
    return {"sent": sent, "wrong": wrong,
            "notes": [f"all closed after {time.monotonic() - began:.0f} s"]}


def few_descriptors(folder):
    """ulimit -n: refused with a word, or served; never an abort."""
    wrong, notes = [], []
    for count in (5, 8, 12, 16, 20, 24, 32, 64):
        daemon = Daemon(f"{folder}/{count}", wait=False,
                        limits=[(resource.RLIMIT_NOFILE, count)])
        end = time.monotonic() + 5.0
        up = False
        while time.monotonic() < end and daemon.process.poll() is None and not up:
            up = served(daemon.tcp, 0.3)
        if daemon.process.poll() is None:
            if not up:
                wrong.append(f"{count} descriptors: neither serves nor ends")
            daemon.stop()
            notes.append(f"{count}: serves" if up else f"{count}: deaf")
            continue
        status, words = daemon.process.returncode, daemon.text().strip()
        notes.append(f"{count}: status {status}")
        if status < 0 or not words:
            wrong.append(f"{count} descriptors: ended with {status} "
                         f"({signal.Signals(-status).name if status < 0 else 'no signal'}), "
                         f"{'silent' if not words else 'said: ' + words[-80:]}")
    return {"wrong": wrong, "notes": notes}


def process_limit(folder):
    """A user that may start few threads: refused with a word, or served, also under calls."""
    wrong, notes = [], []
    user = 60_123 if os.getuid() == 0 else None
    if user is None:
        return {"notes": ["not on this host: needs root, to be another user"]}
    for count in (4, 8, 12, 20, 40):
        daemon = Daemon(f"{folder}/{count}", wait=False, user=user,
                        limits=[(resource.RLIMIT_NPROC, count)])
        end = time.monotonic() + 5.0
        up = False
        while time.monotonic() < end and daemon.process.poll() is None and not up:
            up = served(daemon.tcp, 0.3)
        if up:
            for _ in range(10):
                control(daemon, "info")
            up = served(daemon.tcp)
        if daemon.process.poll() is None:
            notes.append(f"{count}: {'serves' if up else 'deaf'}")
            if not up:
                wrong.append(f"{count} threads: neither serves nor ends")
            daemon.stop()
        else:
            status, words = daemon.process.returncode, daemon.text().strip()
            notes.append(f"{count}: status {status}")
            if status < 0 or not words:
                wrong.append(f"{count} threads: ended with {status}: {words[-80:]}")
    return {"wrong": wrong, "notes": notes}
