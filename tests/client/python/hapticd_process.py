"""A hapticd of a test's own, on a socket in a folder of its own. $HAPTICD and $HAPTIC_SCENES say
where program and scenes are."""

from __future__ import annotations

import os
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence


def eventually(condition: Callable[[], bool], seconds: float = 20.0) -> bool:
    latest = time.monotonic() + seconds
    while time.monotonic() < latest:
        if condition():
            return True
        time.sleep(0.01)
    return False


class Hapticd:
    def __init__(self, scene: str, *, udp: bool = False, lease_s: int = 2, patient: bool = True,
                 tcp: bool = False, settings: Sequence[str] = ()) -> None:
        """`patient`: force survives a pause of a second of its client. `tcp`: not on a socket of
        UNIX."""
        self._folder = tempfile.TemporaryDirectory()
        self.address = "unix:" + os.path.join(self._folder.name, "socket")
        if tcp:
            with socket.socket() as free:
                free.bind(("127.0.0.1", 0))
                self.address = f"127.0.0.1:{free.getsockname()[1]}"
        arguments = [os.environ["HAPTICD"], "--scene",
                     os.path.join(os.environ["HAPTIC_SCENES"], scene + ".textproto"),
                     "--realtime=off", "--log-level=warn", "--listen", self.address,
                     # A loaded machine is no fault of the client.
                     "--set", "loop.late_bucket_full=1000000",
                     "--set", "loop.loop_late_fault={seconds: 10}",
                     "--set", f"server.lease_timeout={{seconds: {lease_s}}}"]
        if patient:
            arguments += ["--set", "device[0].staleness={hold_end {seconds: 1} "
                                   "fade_end {seconds: 1 nanos: 500000000}}"]
        if udp:
            arguments += ["--set", "server.udp_listen=127.0.0.1:0"]
        for setting in settings:
            arguments += ["--set", setting]
        self._process = subprocess.Popen(arguments, stderr=subprocess.DEVNULL)
        latest = time.monotonic() + 20
        while not self._listens():
            if time.monotonic() > latest or self._process.poll() is not None:
                raise RuntimeError("hapticd did not start")
            time.sleep(0.02)

    def _listens(self) -> bool:
        """The socket's file is there a moment before connections are taken."""
        if self.address.startswith("unix:"):
            family, place = socket.AF_UNIX, self.address.removeprefix("unix:")
        else:
            family, place = socket.AF_INET, ("127.0.0.1", int(self.address.rpartition(":")[2]))
        with socket.socket(family) as probe:
            return probe.connect_ex(place) == 0

    @property
    def pid(self) -> int:
        return self._process.pid

    def stop(self) -> None:
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()
