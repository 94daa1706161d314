"""hapticd and other programs as the processes of a long run, and the server's metrics."""

from __future__ import annotations

import contextlib
import pathlib
import re
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence

METRICS = re.compile(r"metrics on port (\d+)")


class Failed(Exception):
    pass


def until(what: str, condition: Callable[[], object], seconds: float = 60.0) -> None:
    latest = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > latest:
            raise Failed(f"not within {seconds:g} s: {what}")
        time.sleep(0.05)


@contextlib.contextmanager
def running(
    arguments: Sequence[object], log: pathlib.Path, stdout: int = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[bytes]]:
    """Ends it by SIGTERM if it still runs; its standard error is in `log`."""
    with open(log, "wb") as file:
        process = subprocess.Popen([str(a) for a in arguments], stdout=stdout, stderr=file)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=30)


@contextlib.contextmanager
def soft_grasp(
    programs: pathlib.Path, scene: pathlib.Path, folder: pathlib.Path, *settings: str
) -> Iterator[str]:
    """hapticd, its log in folder/hapticd.log, under the soft grasp; the address of its metrics."""
    log, socket = folder / "hapticd.log", folder / "socket"
    # Late ticks are counted; they must not end the run by a fault.
    settings += ("server.metrics_listen=127.0.0.1:0", "loop.late_bucket_full=1000000")
    command = [programs / "server/hapticd", "--scene", scene, "--listen", f"unix:{socket}"]
    for setting in settings:
        command += ["--set", setting]
    with running(command, log) as server:
        until(
            "hapticd's start",
            lambda: socket.exists()
            and METRICS.search(log.read_text())
            or server.poll() is not None,
        )
        metrics = METRICS.search(log.read_text())
        if metrics is None or server.poll() is not None:
            raise Failed("hapticd did not start:\n" + log.read_text())
        grasp = [programs / "client/haptic-example-soft-grasp", "--server", f"unix:{socket}"]
        with running(grasp, folder / "grasp.log") as client:
            yield f"http://127.0.0.1:{metrics[1]}/metrics"
            if client.poll() is not None:
                raise Failed("the client ended:\n" + (folder / "grasp.log").read_text())


class Page:
    """One scrape."""

    def __init__(self, url: str) -> None:
        with urllib.request.urlopen(url, timeout=10) as answer:
            self.text = answer.read().decode()
        self.at = time.monotonic()

    def value(self, name: str, labels: str = "") -> float:
        """Of the one series whose labels match, all together, the expression."""
        found = re.search(rf"^{name}(?:\{{{labels}\}})? (\S+)$", self.text, re.M)
        if found is None:
            raise Failed(f"no {name} in the metrics")
        return float(found[1])

    def by_label(self, name: str, label: str) -> list[tuple[str, float]]:
        found = re.findall(rf'^{name}\{{.*{label}="([^"]+)"\}} (\S+)$', self.text, re.M)
        return [(value, float(n)) for value, n in found]


def between(before: Page, after: Page, histogram: str) -> list[tuple[float, int]]:
    """What came between two scrapes: (upper bound, how many in all up to it), +inf last."""
    scraped = (page.by_label(histogram + "_bucket", "le") for page in (before, after))
    return [(float(bound), int(n - m)) for (_, m), (bound, n) in zip(*scraped)]
