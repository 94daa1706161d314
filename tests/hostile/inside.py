"""Attacks from inside the front: the front of the product, confined, with one thread more that does
what it is told (front/inside.hpp). The table of these modes, and what each must come to."""

import contextlib
import dataclasses
import os
import pathlib
import random
import re
import select
import signal
import time
import urllib.request

from daemon import MB, Daemon, asked_locally, control, data_limit, descendants, local_stop
from faults import until_served
from judge import read_record
from signals import dirty

PROGRAM = os.environ.get("HAPTIC_FRONT_ATTACKER", "haptic-front-attacker")
PATIENCE_S = 60.0
USER = 65534  # that runs hapticd in some rows, instead of root
LOG_RATE = 2 * MB  # per second, of the log on the owner's side


def environment(folder, landlock=None):
    """For hapticd: its front is the attacker's. `landlock`: the version that the kernel is to have;
    0: none."""
    place = pathlib.Path(folder) / "front"
    place.mkdir(parents=True)
    (place / "hapticd-front").symlink_to(PROGRAM)
    for name in ("commands", "answers"):
        os.mkfifo(place / name)
        os.chmod(place / name, 0o666)
    if landlock is not None:
        (place / "landlock").write_text(str(landlock))
    return {"HAPTICD_FRONT": str(place / "hapticd-front")}


class Attacker:
    """The thread in the front of a daemon."""

    def __init__(self, daemon):
        place = daemon.folder / "front"
        self.commands, self.answers = (os.open(place / name, os.O_RDWR | os.O_NONBLOCK)
                                       for name in ("commands", "answers"))

    def tell(self, mode, seconds, *words):
        os.write(self.commands, " ".join([mode, str(seconds), *map(str, words)]).encode())

    def hear(self, seconds):
        """Lines until "done", or for so long."""
        end, text = time.monotonic() + seconds, b""
        while time.monotonic() < end and not text.endswith(b"done\n"):
            if select.select([self.answers], [], [], 0.1)[0]:
                text += os.read(self.answers, 1 << 16)
        return text.decode(errors="replace").splitlines()


def control_names(daemon):
    """Where the local control socket may be; '@': in the abstract namespace."""
    names = [f"@hapticd/127.0.0.1:{daemon.port}"]
    with contextlib.suppress(OSError):
        for line in pathlib.Path("/proc/net/unix").read_text().splitlines():
            path = line.split()[-1]
            if "hapticd" in path and str(daemon.port) in path and path not in names:
                names.append(path)
    return names


def words_of(daemon):
    """What %-words of a command stand for."""
    family = descendants(daemon.pid)
    launcher = next((pid for pid, name in family.items() if name.startswith("hapticd-launch")), 1)
    return {"%owner": daemon.pid, "%launcher": launcher, "%folder": daemon.folder,
            "%control": " ".join(control_names(daemon)), "%metrics": daemon.metrics,
            "%port": daemon.port}


@dataclasses.dataclass(frozen=True)
class Mode:
    name: str
    finding: str
    expected: str
    command: str  # mode of the attacker, then words; " + " stands between several, in turns
    seconds: float = 2.5
    ends: bool = False  # the front is killed in the end: another must serve
    landlock: int | None = None
    more: dict = dataclasses.field(default_factory=dict)  # fields of its row
    after: object = None  # after(daemon, what the attacker said): what is wrong

    def __call__(self, daemon):
        attacker = Attacker(daemon)
        before = daemon.log.stat().st_size
        said, missing = [], False
        for command in told(self, self.seconds, words_of(daemon)):
            attacker.tell(*command)
            said += attacker.hear(command[1] + (0.5 if self.ends else 8.0))
            missing = missing or said[-1:] != ["done"]
        wrong = [line for line in said if line.startswith(("GOT IN", "unknown"))]
        if missing and not self.ends:
            wrong.append("the attacker did not end")
        if self.ends:
            kill_fronts(daemon)
        if self.after:
            wrong += self.after(daemon, said)
        grown = (daemon.log.stat().st_size - before) / self.seconds
        if grown > LOG_RATE:
            wrong.append(f"the log grew by {grown / MB:.0f} MB/s")
        return {"wrong": wrong, "notes": [summary(said)]}


def told(mode, seconds, stands_for):
    """The parts of each command, which share the time."""
    commands = [command.split() for command in mode.command.split(" + ")]
    return [(name, seconds / len(commands), *[stands_for.get(word, word) for word in words])
            for name, *words in commands]


def kill_fronts(daemon):
    for pid in daemon.fronts():
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def summary(said):
    """How calls were denied, and what else was said."""
    how = {}
    for line in said:
        if line.startswith("denied"):
            how[line.split(": ")[-1]] = how.get(line.split(": ")[-1], 0) + 1
    words = [f"{count} {name}" for name, count in sorted(how.items())]
    other = [line for line in said if not line.startswith(("denied", "GOT IN")) and line != "done"]
    return ", ".join((["denied: " + ", ".join(words)] if words else []) + other) or "done"


def took_no_more(daemon, said):
    """Memory beyond the limit on data, by what the attacker got."""
    limit = next(filter(None, map(data_limit, daemon.fronts())), 512 * MB) / MB
    return [f"{line} MB, the limit is {limit:.0f}" for line in said
            if re.fullmatch(r"[a-z]+ \d+", line) and int(line.split()[1]) > 1.2 * limit]


def clean_log(daemon, said):
    """Lines of the owner keep coming, and none is forged."""
    found = dirty(daemon.log.read_bytes())
    return [f"in the log: {' '.join(sorted(found))}"] if found else []


def untouched(daemon, said):
    """Every try to change a socket that others have too was refused."""
    tries = [line for line in said if re.search(r" of \d+: ", line)]
    return [line for line in tries if not line.endswith(": EPERM")] or ([] if tries else ["no try"])


def unwatched(daemon, said):
    """No epoll watches what others have too."""
    return [] if "watches 0" in said else [line for line in said if line.startswith("watches")]


def restarts(daemon, said):
    """A front that beats and does nothing else is replaced when the operator says so."""
    _, status, words = control(daemon, "restart-front", timeout=20.0)
    return [] if status == 0 else [f"restart-front: {words[-80:]}"]


def every_tick(daemon, said):
    """The recording lacks none, and neither it nor the log waits, however busy the front keeps the
    host."""
    fifo = daemon.realtime()
    if fifo and not {"haptic-record", "haptic-log"} <= fifo:
        return [f"recording or log waits for ordinary programs: {fifo}"]
    ticks = read_record(daemon.record)
    lost = sum(now.seq - before.seq - 1 for before, now in zip(ticks, ticks[1:]))
    return [f"{lost} ticks are not recorded"] if lost else []


def stays_stopped(daemon, said):
    """The spare device, which is stopped all the time: no clear of it was obeyed."""
    time.sleep(0.4)  # what is recorded is written by then
    record = daemon.folder / "run-spare.csv"
    with open(record, encoding="utf-8") as rows:
        column = next(rows).rstrip("\n").split(",").index("state")
        states = [row.split(",")[column] for row in rows if row.count(",") >= column]
    first = states.index("FAULT") if "FAULT" in states else len(states)
    freed = [state for state in states[first:] if state != "FAULT"]
    return [f"a local stop was cleared: {freed[0]}"] if freed or first == len(states) else []


def last_word(daemon, said):
    """What a front said before its end counts: the finger is stopped. It is cleared for what
    follows."""
    time.sleep(0.3)
    words = asked_locally(daemon, "health").decode()
    if "device\tfinger\tFAULT" not in words:
        return [f"the last stop of a front was not obeyed: {words!r}"]
    _, status, why = control(daemon, "--device", "finger", "clear-fault")
    return [] if status == 0 else [f"clear-fault: {why}"]


def speaks_on(daemon, said):
    """What a front left behind can be read: lists, events, metrics and health."""
    from calls import OBSERVER, Session, outcome, service, stub
    until_served(daemon)
    calls = stub(daemon)
    wrong = [f"ListDevices: {what}" for what in
             [outcome(calls.ListDevices, service.ListDevicesRequest())] if what != "OK"]
    for device in ("finger", "spare"):
        session = Session(calls, device=device, role=OBSERVER, events_after_ns=1)
        if not session.open() or time.sleep(0.2) or session.error:
            wrong.append(f"events of {device}: {session.error}"[:300])
        session.end()
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{daemon.metrics}/metrics") as page:
            for line in page.read().decode().splitlines():
                if not line.startswith("#"):
                    float(line.rsplit(" ", 1)[1])
        words = asked_locally(daemon, "health")
        wrong += [f"health: {words!r}"] * (dirty(words.replace(b"\t", b"")) != [])
    except (OSError, ValueError, IndexError) as why:
        wrong.append(f"metrics, health: {why!r}")
    return wrong + clean_log(daemon, said)


def as_many_threads(daemon, said):
    """What a front may have: some hundreds."""
    return [f"{line}: a thousand are too many" for line in said
            if line.startswith("threads") and int(line.split()[1]) > 25]


DENIED = "denied"
SURVIVED = "owner, stops and force as without; served again within 1 s"
ALL_CALLS = "calls %owner %launcher %folder %control"
MEMORY = ("private", "shared", "memfd", "tmpfs", "shmget", "pipes", "sockets", "growing")

MODES = [
    Mode("calls", "F2 F4 F11", DENIED, ALL_CALLS, 1.0),
    *[Mode(f"calls_landlock_{version}", "F4", DENIED, ALL_CALLS, 1.0, landlock=version)
      for version in (0, 1, 2, 5)],
    *[Mode(f"setown{suffix}", "F4", "no signal", "setown %owner %launcher", landlock=version)
      for suffix, version in (("", None), ("_landlock_0", 0), ("_landlock_5", 5))],
    Mode("calls_user", "F4 F11", DENIED, ALL_CALLS, 1.0, more={"user": USER}),
    Mode("setown_user", "F4", "no signal", "setown %owner %launcher", landlock=0,
         more={"user": USER}),
    Mode("blocking", "F1", SURVIVED, "blocking", ends=True),
    Mode("blocking_deaf", "F1", SURVIVED, "blocking deaf", ends=True),
    Mode("futexes", "F5", SURVIVED, "mapped", 4.0, ends=True),
    Mode("epolls", "new", SURVIVED, "epolls", 6.0, ends=True, after=unwatched),
    Mode("locks", "F1", SURVIVED, "locks"),
    *[Mode(f"sockets_{how}", "F1", SURVIVED, f"sockets {how}", ends=True, after=untouched)
      for how in ("shut", "filter", "backlog", "link")],
    Mode("rights", "F1", SURVIVED, "rights", ends=True),
    Mode("lingering", "F1", SURVIVED, "lingering", ends=True),
    Mode("operates", "F1", "force within its limits", "operate", 4.0),
    Mode("clears", "F2", "a local stop stays", "clears", after=stays_stopped),
    Mode("requests", "F5", SURVIVED, "requests", more={"term_under": True}),
    Mode("samples", "F5", SURVIVED, "samples", more={"term_under": True}),
    Mode("lies", "F5", SURVIVED, "lies", ends=True, after=clean_log),
    Mode("odd", "F5", SURVIVED, "odd", ends=True),
    *[Mode(f"memory_{kind}", "F11", "no more than the limit", f"memory {kind}", 6.0, ends=True,
           after=took_no_more, more={"seconds": 40.0}) for kind in MEMORY],
    Mode("users", "F11", SURVIVED, "users", 5.0, ends=True),
    Mode("users_user", "F11", SURVIVED, "users", 5.0, ends=True, more={"user": USER}),
    Mode("noise", "F11", SURVIVED, "noise", 5.0),
    Mode("log", "F14", "clean, and bounded", "log", after=clean_log),
    Mode("log_shut", "F1", SURVIVED, "log shut", ends=True),
    *[Mode(f"dies_{how}", "F12", SURVIVED, f"dies {how}", 0.3, ends=True)
      for how in ("exit", "abort", "overflow")],
    Mode("stops_itself", "F12", "replaced", "dies stop", ends=True, more={"silent": True}),
    Mode("hangs", "F12", "replaced when asked", "dies hang", after=restarts),
    # The second review: none of these was known before.
    Mode("threads", "second", "some hundreds", "memory threads", ends=True, after=as_many_threads),
    Mode("wakes", "second", SURVIVED, "wakes timers + wakes alarms + wakes nests", 6.0),
    Mode("computes", "second", SURVIVED, "computes spin + computes", 5.0, ends=True,
         after=every_tick, more={"silent": True}),
    Mode("limits", "second", SURVIVED, "limits files + limits memory", ends=True),
    Mode("limits_cpu", "second", SURVIVED, "limits cpu", ends=True),
    Mode("zombie", "second", SURVIVED, "zombie", ends=True),
    Mode("closes", "second", "replaced when asked", "closes samples + closes log", after=restarts),
    Mode("closes_link", "second", "replaced", "closes link", 3.0, ends=True,
         more={"silent": True}),
    Mode("reaches", "second", "connects to nothing", "reaches %metrics %port", ends=True),
    Mode("messages", "second", "refused; force within its limits, and back",
         "replays + moods + stops + leases", 8.0, after=clean_log),
    Mode("bits", "second", "force within its limits, all can be read", "bits", 4.0, ends=True,
         after=speaks_on),
    Mode("times", "second", "force within its limits, and back", "times", ends=True),
    Mode("legacy", "second", "all can be read", "beats + texts", ends=True, after=speaks_on),
    Mode("last_words", "second", "obeyed", "stops last", 0.3, ends=True, after=last_word,
         more={"causes": ("EMERGENCY_STOP",)}),
    Mode("words", "second", "clean, and bounded", "words", after=clean_log),
    Mode("stubborn", "second", "SIGTERM in 5 s", "dies hang", ends=True,
         more={"term_under": True}),
]


def several(daemon):
    """Five modes side by side, other ones each time; the front is killed in the end."""
    attacker, stands_for = Attacker(daemon), words_of(daemon)
    chosen = random.sample([m for m in MODES if m.landlock is None and not m.more.get("user") and
                            not m.more.get("causes")], 5)
    for mode in chosen:
        for command in told(mode, 4.0, stands_for):
            attacker.tell(*command)
            time.sleep(0.2)
    time.sleep(4.0)
    kill_fronts(daemon)
    return {"notes": [" ".join(mode.name for mode in chosen)],
            "silent": any(mode.more.get("silent") for mode in chosen)}


def without_times(folder, mode, user=None):
    """A mode with neither controller nor judgement of times, on a machine that may be slow: (what
    was wrong, notes, the log)."""
    daemon = Daemon(folder, env=environment(folder, mode.landlock), user=user, wait=False)
    try:
        daemon.wait_served(PATIENCE_S)
        local_stop(daemon)
        answer = mode(daemon)
        wrong = answer["wrong"]
        if daemon.process.poll() is None:
            if until_served(daemon, PATIENCE_S / 2) is None:
                wrong.append("not served again")
            try:
                local_stop(daemon)
            except OSError as why:
                wrong.append(f"local stop: {why}")
        took, status = daemon.stop(PATIENCE_S / 2)
        if status != 0:
            wrong.append(f"hapticd ended with {status} after {took:.0f} s")
        return wrong, "; ".join(answer["notes"]), daemon.text()
    finally:
        daemon.kill()
