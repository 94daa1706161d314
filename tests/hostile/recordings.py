"""Recordings: overwritten, linked, cut off, lost; disks that are full."""

import contextlib
import os
import pathlib
import resource
import signal
import subprocess
import time

from daemon import FINGER, Daemon

RECORDED = 'record {{ file: "{}" }}\n'


def one_device(folder, **more):
    return Daemon(folder, devices=FINGER, **more)


def rows_of(folder):
    return {file.name: file.read_bytes() for file in sorted(pathlib.Path(folder).glob("*.csv*"))}


def record_restart(folder):
    """The same record.file again: the former recording stays as it was."""
    daemon = one_device(folder)
    time.sleep(1.0)
    daemon.stop()
    first = rows_of(folder)
    daemon = one_device(folder)
    time.sleep(0.5)
    daemon.stop()
    kept = list(rows_of(folder).values())
    wrong = [f"{name}: {len(data)} bytes are gone" for name, data in first.items()
             if data not in kept]
    return {"wrong": wrong, "notes": [f"files: {' '.join(rows_of(folder))}"]}


def record_two(folder):
    """Two daemons with one record.file: each has its own, or the second is refused."""
    first = one_device(folder)
    time.sleep(0.5)
    file = pathlib.Path(folder) / "run.csv"
    second = Daemon(f"{folder}/two", devices=FINGER, record=False, wait=False,
                    scene=RECORDED.format(file))
    time.sleep(1.5)
    both = second.process.poll() is None
    second.stop()
    first.stop()
    wrong = []
    for name, data in rows_of(folder).items():
        lines = data.split(b"\n")
        columns = lines[0].count(b",")
        broken = sum(1 for line in lines[1:-1] if line.count(b",") != columns)
        seqs = [int(line.split(b",")[1]) for line in lines[1:-1] if line.count(b",") == columns]
        if broken or any(b <= a for a, b in zip(seqs, seqs[1:])):
            wrong.append(f"{name}: {broken} broken rows, ticks out of order")
    whole = [data for data in rows_of(folder).values() if data.count(b"\n") > 300]
    if both and len(whole) < 2 and not wrong:
        wrong.append("two daemons, one file")
    return {"wrong": wrong, "notes": ["both ran" if both else "the second was refused"]}


def record_symlink(folder):
    """record.file is a symbolic link, to a file and to nothing; a device; a FIFO; a folder."""
    wrong, notes = [], []
    victim = pathlib.Path(folder) / "victim"
    victim.write_text("precious\n" * 100)
    before = victim.read_bytes()
    for name in ("link", "dangling", "fifo", "folder"):
        place = pathlib.Path(folder) / name
        place.mkdir()
        file = place / "run.csv"
        if name == "link":
            file.symlink_to(victim)
        elif name == "dangling":
            file.symlink_to(pathlib.Path(folder) / "made-by-attack")
        elif name == "fifo":
            os.mkfifo(file)
        else:
            file.mkdir()
        daemon = Daemon(f"{folder}/{name}-run", devices=FINGER, record=False, wait=False,
                        scene=RECORDED.format(file))
        with contextlib.suppress(RuntimeError):
            daemon.wait_served(4.0)
        if daemon.process.poll() is None:
            time.sleep(0.3)
            notes.append(f"{name}: serves")
        took, status = daemon.stop(8.0)
        if took > 5.0 or status is None or status < 0:
            wrong.append(f"{name}: ended with {status} after {took:.1f} s")
    if victim.read_bytes() != before:
        wrong.append("the file behind a link was written")
    if (pathlib.Path(folder) / "made-by-attack").exists():
        wrong.append("a dangling link was followed")
    return {"wrong": wrong, "notes": notes}


def file_size_limit(folder):
    """RLIMIT_FSIZE reached: the recording ends at a whole row, hapticd goes on. Set at the start
    the limit also holds for the memory that owner and front share: then refused with a word."""
    refused = one_device(f"{folder}/refused", wait=False,
                         limits=[(resource.RLIMIT_FSIZE, 300_000)])
    with contextlib.suppress(subprocess.TimeoutExpired):
        refused.process.wait(5.0)
    if refused.process.poll() is not None and (refused.process.returncode < 0 or
                                               "File too large" not in refused.text()):
        return {"wrong": [f"ended with {refused.process.returncode}: {refused.text()[-80:]}"]}
    refused.stop()
    daemon = one_device(folder)
    resource.prlimit(daemon.pid, resource.RLIMIT_FSIZE, (300_000, 300_000))
    time.sleep(2.5)
    died = daemon.process.poll()
    _, status = daemon.stop()
    wrong = []
    if died is not None:
        name = signal.Signals(-died).name if died < 0 else f"status {died}"
        wrong.append(f"hapticd died: {name}")
    elif status != 0:
        wrong.append(f"ended with {status}")
    return {"wrong": wrong + half_rows(folder)}


def half_rows(folder):
    return [f"{name} ends in half a row" for name, data in rows_of(folder).items()
            if data and not data.endswith(b"\n")]


def full_disk(folder):
    """A file system of 400 KB under the recording: ends at a whole row, said once."""
    place = pathlib.Path(folder) / "small"
    place.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", place],
                          capture_output=True)
    if done.returncode != 0:
        return {"notes": ["not on this host: may not mount a small file system"]}
    try:
        daemon = Daemon(f"{folder}/run", devices=FINGER, record=False,
                        scene=RECORDED.format(place / "run.csv"))
        time.sleep(2.5)
        died = daemon.process.poll()
        took, status = daemon.stop()
        wrong = half_rows(place)
        if died is not None or status != 0 or took > 5.0:
            wrong.append(f"hapticd ended with {status} after {took:.1f} s")
        if "No space left" not in daemon.text():
            wrong.append("the log does not say that the disk is full")
    finally:
        subprocess.run(["umount", place], capture_output=True)
    return {"wrong": wrong}


def record_flush(folder):
    """100 Hz for 4 s, then SIGKILL: the recording lacks 0.25 s at most, and ends at a whole row."""
    daemon = one_device(folder, scene="loop { period { nanos: 10000000 } "
                                      "loop_late_fault { seconds: 1 } }\n")
    time.sleep(4.0)
    killed = time.monotonic_ns()
    daemon.kill()
    wrong = []
    for name, data in rows_of(folder).items():
        lines = data.split(b"\n")
        header = lines[0].split(b",")
        if len(lines) < 3:
            wrong.append(f"{name}: {len(data)} bytes after 4 s")
            continue
        last = lines[-2].split(b",")
        at = int(last[header.index(b"server_time_ns")])
        missing = 1e-9 * (killed - at)
        if missing > 0.3:
            wrong.append(f"{name}: lacks the last {missing:.1f} s")
    return {"wrong": wrong}
