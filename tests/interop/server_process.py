"""hapticd as a child process with one finger at rest, TCP and UDP on free ports of the loopback."""

import contextlib
import os
import signal
import socket
import subprocess
import tempfile
import time

import grpc

# Late ticks and late samples are no fault: these tests judge protocols, not the machine.
SCENE = """
name: "a finger for other people's software"
loop {{ loop_late_fault {{ seconds: 2 }} late_bucket_full: 1000000 }}
server {{ udp_listen: "127.0.0.1:{udp}" {server} }}
device {{
  name: "finger"
  simulated_finger {{ target_mcp_rad: 0.5236 target_pip_rad: 0.5236 }}
  finger_exoskeleton {{}}
  direction_guard {{}}
  impedance {{ stiffness_n_per_m: 1500 damping_n_s_per_m: 0.5 }}
  limits {{ force_n: 25 }}
  staleness {{ hold_end {{ seconds: 1 }} fade_end {{ seconds: 1 nanos: 500000000 }} }}
}}
"""


def free_port(kind):
    """Below the ports that the kernel gives out, so that no other test gets it meanwhile."""
    for i in range(2000):
        port = 12_000 + (37 * os.getpid() + 7 * i) % 17_000
        with socket.socket(socket.AF_INET, kind) as probe:
            with contextlib.suppress(OSError):
                probe.bind(("127.0.0.1", port))
                return port
    raise AssertionError("no free port on 127.0.0.1")


class Server:
    def __init__(self, program, *arguments, stderr=None, server=""):
        """`server`: further fields of the scene's."""
        self.port = free_port(socket.SOCK_STREAM)
        self.udp_port = free_port(socket.SOCK_DGRAM)
        self.scene = tempfile.NamedTemporaryFile("w", suffix=".textproto")
        self.scene.write(SCENE.format(udp=self.udp_port, server=server))
        self.scene.flush()
        self.address = f"127.0.0.1:{self.port}"
        self.process = subprocess.Popen(
            [program, "--scene", self.scene.name, "--listen", self.address, *arguments],
            stderr=stderr)

    def __enter__(self):
        self.channel = grpc.insecure_channel(self.address)
        grpc.channel_ready_future(self.channel).result(timeout=60)
        return self

    def __exit__(self, *_):
        self.channel.close()
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=60)
        assert code == 0, f"hapticd ended with {code}"


def eventually(condition, what, seconds=60.0):
    """Waits until `condition()` holds, for a minute at most by default."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.005)
    raise AssertionError(f"never: {what}")


def argument(name):
    """A folder or program that CMake names in the environment."""
    return os.environ[name]
