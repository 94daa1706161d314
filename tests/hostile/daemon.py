"""A hapticd of its own for every row: a finger that presses and a spare device that is stopped."""

import contextlib
import dataclasses
import multiprocessing
import os
import pathlib
import resource
import signal
import socket
import subprocess
import sys
import threading
import time

from frames import served

PROGRAM = os.environ.get("HAPTICD", "hapticd")
CONTROL = os.environ.get("HAPTICCTL", "hapticctl")
MB = 1 << 20
SLEW, FORCE = 2500.0, 25.0  # N/s, N: of the finger
ADDRESS_SPACE = 3 << 30  # of the daemon under attack

FINGER = """
device {
  name: "finger"
  simulated_finger { target_mcp_rad: 0.5236 target_pip_rad: 0.5236 }
  finger_exoskeleton {}
  direction_guard {}
  impedance { stiffness_n_per_m: 1500 damping_n_s_per_m: 0.5 }
  limits { force_n: 25 slew_n_per_s: 2500 }
}
"""
SPARE = """
device {
  name: "spare"
  simulated_linear { mass: 0.1 damping: 1 max_effort: 1 }
  linear {
    dof { name: "z" unit: "m" actuated: true lower: -1 upper: 1 }
    coordinate { name: "z" unit: "m" }
    A: 1
  }
  impedance { stiffness_n_per_m: 10 }
  limits { force_n: 1 }
}
"""


def free_port(kind, taken=[0]):
    """Below the ports that the kernel gives out, so that no other program gets it meanwhile."""
    for _ in range(3000):
        taken[0] += 7
        port = 12_000 + (37 * os.getpid() + taken[0]) % 17_000
        with socket.socket(socket.AF_INET, kind) as probe:
            with contextlib.suppress(OSError):
                probe.bind(("127.0.0.1", port))
                return port
    raise RuntimeError("no free port on 127.0.0.1")


def descendants(pid):
    """{pid: name} of the process and all that it started."""
    parents = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            with contextlib.suppress(OSError):
                text = pathlib.Path(f"/proc/{entry}/stat").read_text()
                name, rest = text[text.index("(") + 1:].rsplit(")", 1)
                parents[int(entry)] = (int(rest.split()[1]), name)
    found, before = {pid: parents.get(pid, (0, ""))[1]}, 0
    while len(found) != before:
        before = len(found)
        found.update({p: name for p, (parent, name) in parents.items() if parent in found})
    return found


def fronts_of(pid):
    return [one for one, name in descendants(pid).items() if name.startswith("hapticd-front")]


def end_all(pid, itself=True):
    """Ends a process and all that it started."""
    for one in descendants(pid):
        if itself or one != pid:
            with contextlib.suppress(ProcessLookupError):
                os.kill(one, signal.SIGKILL)


def resident(pid):
    """Bytes; 0 if it is gone."""
    try:
        return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096
    except (OSError, IndexError):
        return 0


def data_limit(pid):
    """RLIMIT_DATA in bytes; None: unlimited, or gone."""
    with contextlib.suppress(OSError):
        for line in pathlib.Path(f"/proc/{pid}/limits").read_text().splitlines():
            if line.startswith("Max data size"):
                word = line.split()[3]
                return None if word == "unlimited" else int(word)
    return None


HERE = pathlib.Path(__file__).parent
PRESSED = ("0.25", "0.5236")  # rad: the first joint is held 0.27 rad short of where it would rest


class Daemon:
    def __init__(self, folder, *arguments, scene="", server="", limits=(), env=None, user=None,
                 record=True, devices=FINGER + SPARE, wait=True, web=False, prefix=(), **more):
        """`limits`: of RLIMIT_*, (which, value) each. `web`: serves browsers too, and an observer's
        token. `prefix`: a program that becomes hapticd. `more`: of subprocess.Popen."""
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.port, self.metrics = free_port(socket.SOCK_STREAM), free_port(socket.SOCK_STREAM)
        self.udp = free_port(socket.SOCK_DGRAM)
        self.tcp, self.unix = ("127.0.0.1", self.port), str(self.folder / "s")
        self.address = f"127.0.0.1:{self.port}"
        self.record, self.log = self.folder / "run-finger.csv", self.folder / "log"
        if web:
            server += self.serve_browsers()
        file = self.folder / "scene.textproto"
        file.write_text(
            'name: "under attack"\n' + (f'record {{ file: "{folder}/run.csv" }}\n' if record else
                                        "") +
            f'server {{ listen: "{self.address}" listen: "unix:{self.unix}"\n'
            f'  udp_listen: "127.0.0.1:{self.udp}"\n'
            f'  metrics_listen: "127.0.0.1:{self.metrics}" {server} }}\n{devices}{scene}')
        limits = ((resource.RLIMIT_AS, ADDRESS_SPACE), (resource.RLIMIT_CORE, 0), *limits)

        def prepare():
            for which, value in limits:
                with contextlib.suppress(ValueError):  # a limit above what this host grants
                    resource.setrlimit(which, (value, value))
            if user is not None:
                os.setgroups([])
                os.setgid(user)
                os.setuid(user)

        if user is not None:
            os.chown(self.folder, user, user)
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [*prefix, PROGRAM, "--scene", str(file), *arguments], preexec_fn=prepare,
                env={**os.environ, **(env or {})},
                **{"stdin": subprocess.DEVNULL, "stdout": log, "stderr": log, **more})
        self.pid = self.process.pid
        if wait:
            self.wait_served()

    def serve_browsers(self):
        """Fields of the scene's `server`."""
        self.web, self.token = ("127.0.0.1", free_port(socket.SOCK_STREAM)), os.urandom(16).hex()
        file = self.folder / "token"
        with open(os.open(file, os.O_CREAT | os.O_WRONLY, 0o600), "w") as stream:
            stream.write(self.token)
        return (f'\n  web {{ listen: "127.0.0.1:{self.web[1]}" token {{ name: "attacker" '
                f'file: "{file}" rights: "observe" }} }}')

    def wait_served(self, seconds=20.0):
        end = time.monotonic() + seconds
        while not served(self.tcp, 0.5):
            if self.process.poll() is not None or time.monotonic() > end:
                self.stop()
                raise RuntimeError("hapticd does not serve:\n" + self.text()[-2000:])
            time.sleep(0.02)

    def text(self):
        return self.log.read_text(errors="replace")

    def fronts(self):
        """The processes that face the network; none: the owner does it itself."""
        return fronts_of(self.pid)

    def stop(self, patience=20.0):
        """SIGTERM; (seconds until it ended, exit status). Killed if that takes too long."""
        began = time.monotonic()
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
        return time.monotonic() - began, self.process.returncode

    def realtime(self):
        """The names of the owner's threads that have SCHED_FIFO."""
        names = set()
        with contextlib.suppress(OSError):
            for stat in pathlib.Path(f"/proc/{self.pid}/task").glob("*/stat"):
                before, after = stat.read_text().rsplit(")", 1)
                names |= {before.split("(", 1)[1]} if after.split()[38] == "1" else set()
        return names

    def kill(self):
        if self.process.poll() is None:
            end_all(self.pid)
        self.process.wait()


def control(daemon, *words, timeout=5.0):
    """hapticctl: (seconds, exit status, what it said)."""
    began = time.monotonic()
    try:
        done = subprocess.run([CONTROL, "--server", daemon.address, *words], timeout=timeout,
                              capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL)
        return time.monotonic() - began, done.returncode, done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        return timeout, -1, "no answer"


@dataclasses.dataclass(frozen=True)
class Way:
    """How a stop is asked for: its limit, how often it is tried, the percentile that must keep the
    limit, and what all rows together must keep."""
    limit_s: float
    every_s: float
    share: float
    longest_s: float


STOP = Way(0.010, 0.010, 0.99, 0.050)  # from connect to answer of the local control socket


def asked_locally(daemon, words):
    """What the local control socket answers. Raises OSError if it does not."""
    name = f"hapticd/127.0.0.1:{daemon.port}"
    path = f"/run/{name}"  # of a hapticd of root
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as control_socket:
        control_socket.settimeout(2.0)
        control_socket.connect(path if os.path.exists(path) else f"\0{name}")
        control_socket.send(words.encode())
        return control_socket.recv(8192)


def local_stop(daemon, device="spare"):
    """Stops a device as root does on this host, by the local control socket: seconds from connect
    to answer. Raises OSError if it was not stopped."""
    began = time.monotonic()
    words = asked_locally(daemon, f"stop {device}\nrow")
    seconds = time.monotonic() - began
    if words != f"ok\n{device}".encode():
        raise OSError(f"{words!r} after {seconds:.3f} s")
    return seconds


def in_time():
    """Real-time scheduling for the calling thread, so that what it measures is the daemon; False
    if the host does not grant it."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        return True
    except (OSError, AttributeError):
        return False


class Probe:
    """Memory of owner and front every 10 ms, and local stops by a process of its own: a thread of
    this one would wait for the interpreter while the system has stopped another."""

    def __init__(self, daemon):
        self.daemon, self.running = daemon, multiprocessing.RawValue("b", True)
        self.owner, self.front, self.front_limit = 0, 0, None
        self.stops, self.unanswered, self.punctual = [], [], False
        self.heard, said = multiprocessing.Pipe(duplex=False)
        self.child = multiprocessing.get_context("fork").Process(target=self.stopping, args=(said,))
        self.child.start()
        said.close()
        self.thread = threading.Thread(target=self.memory)
        self.thread.start()

    def memory(self):
        in_time()
        looked, fronts = 0.0, []
        while self.running.value:
            if time.monotonic() > looked + 0.3:
                looked, fronts = time.monotonic(), self.daemon.fronts()
                for pid in fronts:
                    self.front_limit = data_limit(pid) or self.front_limit
            self.owner = max(self.owner, resident(self.daemon.pid))
            self.front = max([self.front, *map(resident, fronts)])
            while self.heard.poll():
                self.take(self.heard.recv())
            time.sleep(0.01)

    def stopping(self, said):
        said.send(in_time())
        while self.running.value:
            try:
                said.send(local_stop(self.daemon))
            except OSError as why:
                said.send(str(why))
            time.sleep(STOP.every_s)
        os._exit(0)  # what libraries would do at an exit is not wanted

    def take(self, said):
        if isinstance(said, bool):
            self.punctual = said
        else:
            (self.stops if isinstance(said, float) else self.unanswered).append(said)

    def end(self):
        self.running.value = False
        self.thread.join()
        with contextlib.suppress(EOFError):
            while True:
                self.take(self.heard.recv())
        self.child.join()
        return self


class Controller:
    """controller.py as a process, and the state it printed last."""

    def __init__(self, address, device="finger", x=PRESSED):
        self.state, self.ended = "", 0
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "controller.py"), address, device, *x],
            env={**os.environ, "PYTHONPATH": os.environ["HAPTIC_PYTHON"]},
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.thread = threading.Thread(target=self.listen)
        self.thread.start()

    def listen(self):
        in_time()
        for line in self.process.stdout:
            if line.startswith("ENDED"):
                self.ended, self.state = self.ended + 1, ""
            else:
                self.state = line.strip()

    def engaged_within(self, seconds):
        """How long it took; None: it did not come."""
        began = time.monotonic()
        while self.state != "ENGAGED":
            if time.monotonic() > began + seconds:
                return None
            time.sleep(0.005)
        return time.monotonic() - began

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.thread.join()
        self.process.stdout.close()
