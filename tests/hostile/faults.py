"""The process that faces the network, killed, stopped and starved; and controls of the suite."""

import os
import signal
import time


def fronts(daemon):
    found = daemon.fronts()
    return found, [] if found else ["no process faces the network apart from the owner"]


def killed(daemon):
    """Three times, 1.5 s apart."""
    wrong = []
    for _ in range(3):
        pids, wrong = fronts(daemon)
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        if pids:
            time.sleep(1.5)
    return {"wrong": wrong}


def frozen(daemon):
    """Stopped: noticed after 2 s, replaced by 3.5 s."""
    pids, wrong = fronts(daemon)
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    if pids:
        time.sleep(3.5)
        if set(pids) & set(daemon.fronts()):
            wrong.append("the frozen front was not replaced within 3.5 s")
            for pid in pids:
                os.kill(pid, signal.SIGCONT)
    return {"wrong": wrong}


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
