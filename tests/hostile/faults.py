"""The process that faces the network, killed and frozen; and controls of the suite."""

import os
import signal
import time

from frames import served

RESTART_S = 1.0  # until a new front serves
NOTICED_S, REPLACED_S = 1.5, 3.5  # a front that hangs: not before, and not after
ALONE = "no process faces the network apart from the owner"


def until_served(daemon, seconds=5.0):
    """None: not within `seconds`."""
    began = time.monotonic()
    while not served(daemon.tcp, 0.3):
        if time.monotonic() > began + seconds:
            return None
        time.sleep(0.01)
    return time.monotonic() - began


def killed(daemon):
    """Three times; a resumable session goes on behind the next front."""
    if not daemon.fronts():
        return {"wrong": [ALONE]}
    from calls import Session, stub
    wrong, notes, calls = [], [], stub(daemon)
    for i in range(3):
        session = Session(calls, device="spare", resumable=True)
        if not session.open():
            return {"wrong": [f"no session: {session.status}"]}
        session.publish([0.0])
        time.sleep(0.1)
        for pid in daemon.fronts():
            os.kill(pid, signal.SIGKILL)
        took = until_served(daemon)
        notes.append("never" if took is None else f"served after {1e3 * took:.0f} ms")
        if took is None or took > RESTART_S:
            wrong.append(f"kill {i}: {notes[-1]}")
        session.end()
        again = Session(stub(daemon), device="spare", resumable=True,
                        resume=session.opened.session_id)
        if not again.open() or not again.opened.resumed:
            wrong.append(f"kill {i}: not resumed {again.status}")
        again.end()
        time.sleep(1.0)
    return {"wrong": wrong, "notes": notes}


def frozen(daemon):
    """Stopped: noticed after 2 s, replaced by 3.5 s."""
    before = set(daemon.fronts())
    if not before:
        return {"wrong": [ALONE]}
    for pid in before:
        os.kill(pid, signal.SIGSTOP)
    began = time.monotonic()
    while before & set(daemon.fronts()) and time.monotonic() < began + REPLACED_S:
        time.sleep(0.01)
    took = time.monotonic() - began
    if before & set(daemon.fronts()):
        for pid in before:
            os.kill(pid, signal.SIGCONT)
        return {"wrong": [f"the frozen front was not replaced within {REPLACED_S} s"]}
    wrong = [f"replaced after {took:.1f} s already"] if took < NOTICED_S else []
    return {"wrong": wrong, "notes": [f"replaced after {took:.1f} s"]}


def stuttering(daemon):
    """Stopped for 0.5 s and on for 0.5 s, five times: a front that is only slow is kept."""
    before = set(daemon.fronts())
    if not before:
        return {"wrong": [ALONE]}
    for _ in range(5):
        for stop in (signal.SIGSTOP, signal.SIGCONT):
            for pid in before & set(daemon.fronts()):
                os.kill(pid, stop)
            time.sleep(0.5)
    kept = before <= set(daemon.fronts())
    return {"wrong": [] if kept else ["a front that was slow was replaced"]}


def deaf(daemon):
    """A positive control: the whole daemon stands still for 2 s, which the suite must notice."""
    os.kill(daemon.pid, signal.SIGSTOP)
    time.sleep(2.0)
    os.kill(daemon.pid, signal.SIGCONT)
    return {}


def stopped_by_hand(daemon):
    """A positive control: a fault that the row does not admit to."""
    from calls import outcome, service, stub
    outcome(stub(daemon).EmergencyStop, service.EmergencyStopRequest(device="finger"))
    return {}
