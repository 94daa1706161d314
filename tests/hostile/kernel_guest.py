#!/usr/bin/python3
"""Process 1 of the machine that kernel.sh boots: some modes of inside.py as root and as a user, a
line each. No times are judged: the machine is slow."""

import ctypes
import fcntl
import os
import socket
import struct
import sys
import time
import traceback

sys.path.insert(0, "/suite")
os.environ.update(PATH="/usr/bin", HAPTICD="/usr/bin/hapticd", HAPTICCTL="/usr/bin/hapticctl",
                  HAPTIC_FRONT_ATTACKER="/usr/bin/haptic-front-attacker")
NAMES = {"calls", "setown", "blocking_deaf", "futexes", "sockets_shut", "sockets_filter",
         "sockets_link", "rights", "lingering", "clears", "memory_memfd", "threads", "limits",
         "zombie", "closes_link", "reaches", "dies_abort", "log"}
POWER_OFF = 0x4321FEDC


def say(words):
    print(f"row: {words}", flush=True)


def prepare():
    libc = ctypes.CDLL(None, use_errno=True)
    for kind, place in (("devtmpfs", "/dev"), ("proc", "/proc"), ("sysfs", "/sys"),
                        ("tmpfs", "/tmp"), ("tmpfs", "/run"), ("devpts", "/dev/pts"),
                        ("tmpfs", "/dev/shm")):
        os.makedirs(place, exist_ok=True)
        libc.mount(kind.encode(), place.encode(), kind.encode(), 0, None)
    os.chmod("/tmp", 0o1777)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, 0x8914, struct.pack("16sH14x", b"lo", 1))  # SIOCSIFFLAGS, IFF_UP
    return libc


def main():
    libc = prepare()
    failed = 0
    try:
        import inside
        modes = [mode for mode in inside.MODES if mode.name in NAMES]
        assert len(modes) == len(NAMES), NAMES - {mode.name for mode in modes}
        landlock = libc.syscall(444, None, 0, 1)
        say(f"Linux {os.uname().release}, Landlock {max(landlock, 0)}")
        for user in (None, inside.USER):
            for mode in modes:
                began = time.monotonic()
                wrong, notes, log = inside.without_times(f"/tmp/{mode.name}-{user}", mode, user)
                for line in log.splitlines():
                    if "confinement" in line:
                        say(f"    {line}")
                failed += bool(wrong)
                say(f"{'FAILED' if wrong else 'held  '} front_{mode.name} as "
                    f"{'root' if user is None else 'a user'} ({time.monotonic() - began:.0f} s): "
                    f"{'; '.join(wrong) or notes}")
        say(f"{failed} failed")
    except Exception:  # noqa: BLE001  process 1 must not end
        say(traceback.format_exc().replace("\n", " | "))
    os.sync()
    libc.reboot(POWER_OFF)


if __name__ == "__main__":
    main()
