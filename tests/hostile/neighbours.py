"""More attacks from outside, by mechanism: other users of this host, one of whom is the front's;
thieves of descriptors, rights and names."""

import contextlib
import ctypes
import json
import os
import pathlib
import resource
import select
import signal
import socket
import struct
import threading
import time

from daemon import Daemon, descendants, fronts_of
from faults import until_served
from frames import PREFACE, connect, served
from outside import SERVED, parts

STRANGER, OTHER, NOBODY = 60_321, 60_322, 65_534  # without rights; the last is a root's front
LINGER = struct.pack("ii", 1, 600)
PASS_RIGHTS = 83  # SO_PASSRIGHTS
NEW_USER_NAMESPACE = 0x10000000
SET_DUMPABLE = 4
ATTACH, SEIZE = 16, 0x4206  # of ptrace()
libc = ctypes.CDLL(None, use_errno=True)


def as_user(user, work, seconds=10.0):
    """The list that `work` answers as that user, in a process of its own."""
    here, there = os.pipe()
    pid = os.fork()
    if pid == 0:
        answer = ["the child failed"]
        try:
            signal.alarm(int(seconds) + 1)
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
            answer = work()
        except Exception as why:  # noqa: BLE001
            answer = [f"did not run: {type(why).__name__}: {why}"]
        finally:
            os.write(there, json.dumps(answer).encode())
            os._exit(0)
    os.close(there)
    text = b""
    while select.select([here], [], [], seconds)[0] and (came := os.read(here, 1 << 16)):
        text += came
    os.close(here)
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    return json.loads(text or b'["no answer"]')


def control_path(daemon, suffix=""):
    return f"/run/hapticd/127.0.0.1:{daemon.port}{suffix}"


def control_name(daemon):
    return f"\0hapticd/127.0.0.1:{daemon.port}"


def asked(place, words, seconds=1.0):
    """The answer of a control socket; an error as text."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as end:
        end.settimeout(seconds)
        try:
            end.connect(place)
            end.send(words)
            return end.recv(65_536)
        except OSError as why:
            return f"error {why}".encode()


def kill_fronts(daemon):
    for pid in daemon.fronts():
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def lingering():
    """A socket whose last close waits for ten minutes, and the one that keeps it so."""
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    listener.bind(("127.0.0.1", 0))
    listener.listen(1)
    end = socket.socket()
    end.connect(listener.getsockname())
    end.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        while True:
            end.send(bytes(1 << 16))
    end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER)
    return end, listener


def burdened(daemon):
    """A user gives the front, and the control socket, descriptors whose close waits, on connections
    in dozens: others are served meanwhile, and another user stops. Kernels before 6.16 cannot
    refuse descriptors."""
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.getsockopt(socket.SOL_SOCKET, PASS_RIGHTS)
        except OSError:
            return {"notes": ["not on this kernel"]}
    os.chmod(daemon.unix, 0o777)

    def give(kind, place, words):
        held = []

        def send(to, number):
            with contextlib.suppress(OSError):
                socket.send_fds(to, [words], [number])
            os.close(number)  # mostly before the other has read: then the last close is its own
        for _ in range(30):
            (end, listener), to = lingering(), socket.socket(socket.AF_UNIX, kind)
            held += [to, listener]
            to.settimeout(0.3)
            with contextlib.suppress(OSError):
                to.connect(place)
                time.sleep(0.02)
                threading.Thread(target=send, args=(to, end.detach()), daemon=True).start()
        time.sleep(3.0)
        return []
    givers = [threading.Thread(target=as_user, args=(STRANGER, lambda all_of=all_of: give(*all_of)))
              for all_of in ((socket.SOCK_STREAM, daemon.unix, PREFACE),
                             (socket.SOCK_SEQPACKET, control_name(daemon), b"stop none"))]
    for giver in givers:
        giver.start()
    time.sleep(2.5)
    wrong = [f"not served meanwhile at {address}" for address in (daemon.tcp, daemon.unix)
             if not served(address, 1.0)]
    answer = as_user(OTHER, lambda: [asked(control_name(daemon), b"stop spare").decode()])[0]
    for giver in givers:
        giver.join()
    return {"wrong": wrong + ([] if answer.startswith("ok") else [f"another's stop: {answer}"])}


def circles(daemon):
    """Sockets to the front that carry themselves in a circle, in thousands: the kernel has to look
    for what nobody holds any more."""
    def send():
        for _ in range(200):
            ends = [connect(daemon.unix, 1.0) for _ in range(2)]
            pair = socket.socketpair(socket.AF_UNIX)
            for _ in range(10):
                with contextlib.suppress(OSError):
                    socket.send_fds(pair[0], [b"x"], [pair[1].fileno(), ends[0].fileno()])
                    socket.send_fds(ends[1], [b"x"], [pair[0].fileno(), ends[1].fileno()])
            for end in (*ends, *pair):
                end.close()
        return []
    return {"wrong": as_user(STRANGER, send)}


def users_without_number(daemon):
    """Sixty users at once ask for stops and health as fast as it goes, as one user with subordinate
    ids may."""
    def ask(words):
        until = time.monotonic() + 3.0
        while time.monotonic() < until:
            asked(control_name(daemon), words, 0.3)
        return []
    threads = [threading.Thread(target=as_user, args=(
        70_000 + i, lambda i=i: ask(b"stop spare\nx" if i % 2 else b"health"))) for i in range(60)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def odd_commands(daemon):
    """Commands that are none, by a user: each is refused in words; nothing is cleared or stopped.
    By root: a number that is too large for the faults is none."""
    odd = [b"clear spare\n0", b"restart-front", b"CLEAR spare", b"stop  spare", b"stop spare ",
           b"stop\tspare", b"stop finger\0spare", b"health finger", b"restart-front now",
           b"x" * 385, b"stop " + b"y" * 60_000, b"\0", b"\n", b"stop \xff\xfe", b"clear",
           b"stop spare/../finger"]

    def ask():
        answers = [(words, asked(place, words)) for words in odd
                   for place in (control_name(daemon), control_path(daemon, ".all"))]
        return [f"{words[:20]!r}: {answer[:60]!r}" for words, answer in answers
                if not answer.startswith((b"refused: ", b"error [Errno 90]", b"error [Errno 104]"))]
    wrong = as_user(STRANGER, ask)
    if "finger by user" in daemon.text():
        wrong.append("a command that is none stopped the finger")
    answer = asked(control_path(daemon), b"clear spare\n99999999999999999999")
    return {"wrong": wrong + ([] if answer.startswith(b"refused: ") else [repr(answer)])}


def borrowed_rights(daemon):
    """A user's socket that a program of root writes to, as one with set-uid would; and root of a
    user's own namespace: neither clears."""
    here, there = socket.socketpair(socket.AF_UNIX)

    def connected():
        end = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        end.connect(control_name(daemon))
        socket.send_fds(there, [b"x"], [end.fileno()])
        return []

    def as_root_of_its_own():
        libc.prctl(SET_DUMPABLE, 1)  # or its files in /proc are root's
        if libc.unshare(NEW_USER_NAMESPACE) == 0:
            pathlib.Path("/proc/self/setgroups").write_text("deny")
            pathlib.Path("/proc/self/uid_map").write_text(f"0 {STRANGER} 1")
        return [asked(control_name(daemon), b"clear spare\n0").decode()]
    wrong = as_user(STRANGER, connected)
    with socket.socket(fileno=socket.recv_fds(here, 1, 1)[1][0]) as end:
        end.settimeout(1.0)
        end.send(b"clear spare\n0")
        answers = [end.recv(1000).decode(), *as_user(STRANGER, as_root_of_its_own)]
    return {"wrong": wrong + [answer for answer in answers if not answer.startswith("refused")]}


def names_of_root(daemon):
    """The folder of the control socket, and ports while fronts die: no other user takes a name."""
    path, names = control_path(daemon), (
        (socket.AF_INET, "127.0.0.1"), (socket.AF_INET, "0.0.0.0"), (socket.AF_INET6, "::"),
        (socket.AF_INET6, "::ffff:127.0.0.1"))

    def folder():
        got = []
        for work in (lambda: os.unlink(path), lambda: os.rename(path, path + "x"),
                     lambda: os.chmod(path, 0o666), lambda: os.symlink("/dev/null", path + ".x"),
                     lambda: socket.socket(socket.AF_UNIX).bind(path + ".y")):
            with contextlib.suppress(OSError):
                work()
                got.append("the folder of the control socket was changed")
        if not asked(path, b"stop spare").startswith(b"error"):
            got.append("the control socket of root answers")
        return got

    def ports():
        got, until = set(), time.monotonic() + 3.0
        while time.monotonic() < until:
            for kind, port in ((socket.SOCK_STREAM, daemon.port), (socket.SOCK_DGRAM, daemon.udp),
                               (socket.SOCK_STREAM, daemon.metrics)):
                for family, host in names:
                    with contextlib.suppress(OSError), socket.socket(family, kind) as end:
                        for option in (socket.SO_REUSEADDR, socket.SO_REUSEPORT):
                            end.setsockopt(socket.SOL_SOCKET, option, 1)
                        if family == socket.AF_INET6:
                            end.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
                        end.bind((host, port))
                        if kind == socket.SOCK_STREAM:
                            end.listen(1)
                        got.add(f"port of hapticd at {host}, {kind.name}")
        return sorted(got)
    killer = threading.Thread(target=lambda: [(time.sleep(0.9), kill_fronts(daemon))
                                              for _ in range(3)])
    killer.start()
    wrong = as_user(STRANGER, ports) + as_user(STRANGER, folder)
    killer.join()
    until_served(daemon)
    return {"wrong": wrong}


def thieves(daemon):
    """The front's user, and another: memory, descriptors, traces and signals of the three."""
    family = descendants(daemon.pid)
    room = ctypes.create_string_buffer(8)
    here, far = (ctypes.c_size_t * 2)(ctypes.addressof(room), 8), (ctypes.c_size_t * 2)(4096, 8)
    calls = {"attach": lambda p: libc.ptrace(ATTACH, p, 0, 0),
             "seize": lambda p: libc.ptrace(SEIZE, p, 0, 0),
             "process_vm_readv": lambda p: libc.syscall(310, p, here, 1, far, 1, 0),
             "kcmp": lambda p: libc.syscall(312, p, os.getpid(), 0, 0, 0),
             "pidfd_getfd": lambda p: libc.syscall(438, os.pidfd_open(p), 3, 0),
             "process_madvise": lambda p: libc.syscall(440, os.pidfd_open(p), far, 1, 21, 0)}
    for name in ("mem", "environ", "maps", "fd/3", "auxv", "syscall"):
        calls[name] = lambda p, f=name: os.open(f"/proc/{p}/{f}", os.O_RDONLY)

    def steal():
        got = []
        for pid, name in family.items():
            for what, work in calls.items():
                with contextlib.suppress(OSError):
                    if work(pid) >= 0:
                        got.append(f"{what} of {name}")
            if not name.startswith("hapticd-front"):
                for number in (signal.SIGSTOP, signal.SIGKILL, signal.SIGIO, 34):
                    with contextlib.suppress(OSError):
                        os.kill(pid, number)
                        got.append(f"signal {number} to {name}")
        return got
    return {"wrong": sorted({*as_user(NOBODY, steal), *as_user(STRANGER, steal)})[:6]}


def squeezed(daemon):
    """The front's user takes the front's limits, processor and time away, again and again: the
    owner goes on, and a front that serves comes back."""
    def squeeze():
        for which, value in ((resource.RLIMIT_NOFILE, 0), (resource.RLIMIT_CPU, 1),
                             (resource.RLIMIT_DATA, 0), (resource.RLIMIT_FSIZE, 0)):
            for pid in fronts_of(daemon.pid):
                for work in (lambda: resource.prlimit(pid, which, (value, value)),
                             lambda: os.setpriority(os.PRIO_PROCESS, pid, 19),
                             lambda: os.sched_setscheduler(pid, os.SCHED_IDLE, os.sched_param(0))):
                    with contextlib.suppress(OSError):
                        work()
            time.sleep(0.3)
        for pid in fronts_of(daemon.pid):
            os.kill(pid, signal.SIGKILL)
        return []
    wrong = as_user(NOBODY, squeeze)
    return {"wrong": wrong + ([] if until_served(daemon) is not None else ["no front serves"])}


def path_of_another(folder):
    """A plain file, and another program's socket, where the UNIX socket was; then a front dies:
    they stay, and the other addresses are served."""
    daemon, wrong = Daemon(folder, record=False), []
    path = pathlib.Path(daemon.unix)

    def front_dies(what):
        kill_fronts(daemon)
        if until_served(daemon) is None:
            wrong.append(f"{what}: not served again")
        time.sleep(0.2)
    path.unlink()
    path.write_text("precious")
    front_dies("file")
    if not path.is_file() or path.read_text() != "precious":
        wrong.append("another's file is gone")
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(daemon.unix)
        other.listen(4)
        other.settimeout(1.0)
        front_dies("socket")
        try:
            connect(daemon.unix, 1.0).close()
            other.accept()[0].close()
        except OSError as why:
            wrong.append(f"another's socket is gone: {why}")
    daemon.stop()
    if not path.exists():
        wrong.append("another's socket is gone in the end")
    return {"wrong": wrong}


ROWS = [("outside_users", SERVED, parts(burdened, circles, users_without_number, odd_commands,
                                        borrowed_rights, root=True), {"seconds": 60.0}),
        ("outside_thieves", SERVED, parts(names_of_root, thieves, squeezed, root=True),
         {"seconds": 60.0}),
        ("outside_path", "it stays", parts(path_of_another), {"alone": True})]
