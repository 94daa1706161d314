"""Boards that lie, and boards that should never have been opened."""

import contextlib
import os
import random
import struct
import time

from board import ARMED, COUNTERS, DISARMED, FAULT, IDENTITY, STATE, STOPPED, Board, dof, dof_two, \
    frame, identity
from daemon import Daemon

SLEW, FORCE, CELL = 2_000.0, 20.0, 50.0
NAN, INFINITE = float("nan"), float("inf")
DEVICE = """
device {{
  name: "board"
  board {{ port: "{port}" max_effort: 50 max_silence {{ nanos: 100000000 }} }}
  linear {{
    dof {{ name: "z" unit: "m" actuated: true lower: -1 upper: 1 }}
    coordinate {{ name: "z" unit: "m" }}
    A: 1
  }}
  {control}
  impedance {{ stiffness_n_per_m: 500 damping_n_s_per_m: 0.5 }}
  limits {{ force_n: 20 slew_n_per_s: 2000 engage_window_n: 10 }}
}}
loop {{ loop_late_fault {{ nanos: 900000000 }} late_bucket_full: 1000000 }}
"""
LOOP = "force_control { server { proportional: 0.5 integral_per_s: 5 output_limit_n: 30 } }"


def serve(board, folder, control="", wait=True):
    return Daemon(folder, devices=DEVICE.format(port=board.port, control=control), wait=wait,
                  record=False)


def press(calls, session, seconds, until=()):
    """Presses with 5 N, asks for force; True once the state is one of `until`."""
    from calls import grpc, service, wire
    end, ask = time.monotonic() + seconds, 0.0
    while time.monotonic() < end:
        session.publish([0.010])
        name = wire.DeviceStateName.Name(session.state.state)[18:] if session.state else ""
        if name in until:
            return True
        if "ENGAGED" in until and time.monotonic() > ask:
            ask = time.monotonic() + 0.1
            if name == "FAULT":
                with contextlib.suppress(grpc.RpcError):
                    calls.ClearFault(service.ClearFaultRequest(device="board"), timeout=1.0)
            with contextlib.suppress(grpc.RpcError):
                calls.Engage(service.EngageRequest(session_id=session.opened.session_id),
                             timeout=1.0)
        time.sleep(0.010)
    return False


def steps(commands):
    """The largest change between consecutive commands, N, beyond what the slew limit allows in
    their time, and in the 4 ms that host and board may be late; what goes to zero is a fault's
    right."""
    worst = 0.0
    for before, now in zip(commands, commands[1:]):
        time_s = max(now[0] - before[0], 0.001 * (now[1] - before[1])) + 0.004
        if now[3] != 0.0 and before[2] == now[2]:
            worst = max(worst, abs(now[3] - before[3]) - SLEW * time_s)
    return worst


def lie_of_cell(name, f):
    board = f["board"]
    if name == "negative":
        f["force"][0] = -60.0
    elif name == "alternating":
        f["force"][0] = 60.0 if f["time"] // 1_000 % 2 else -60.0
    elif name == "stuck":
        f["force"][0] = 0.0
    elif name == "frozen":
        f["force"][0] = 5.0
    elif name == "wrong_sign":
        f["force"][0] = -board.cell
    elif name == "jumps":
        f["force"][0] = 45.0 if f["time"] // 50_000 % 2 else -45.0
    elif name == "disconnected":
        f["force"][0] = random.gauss(0.0, 0.03)
    elif name == "drifting":
        board.drift += 0.020
        f["force"][0] += board.drift


LINK = 1 << 1 | 1 << 2  # DEVICE_SILENT, DEVICE_LOST: of this host, which held the board up


def one_lie(lie, board, folder):
    """(what was wrong, when the fault came); None: the host held the board up."""
    daemon = serve(board, folder, LOOP)
    try:
        from calls import Session, stub
        calls = stub(daemon)
        session = Session(calls, device="board")
        if not session.open() or not press(calls, session, 12.0, ("ENGAGED",)):
            return [f"{lie}: no force before the lie"], None
        press(calls, session, 0.5)
        honest = board.commands()
        board.tell(lie)
        began = time.monotonic()
        while time.monotonic() < began + 2.0:  # the stuck cell shows only while the drive changes
            session.publish([0.010 + 0.008 * (int(10 * time.monotonic()) % 2)])
            if session.state.state == 7:
                break
            time.sleep(0.010)
        faulted = time.monotonic() - began if session.state.state == 7 else None
        by_link = session.state.faults & ~LINK == 0
        press(calls, session, 0.3)
        commands = board.commands()
        session.end()
    finally:
        daemon.stop()
        board.end()
    if faulted is not None and by_link:
        return None
    values, wrong, over = [c[3] for c in commands], [], steps(honest[-50:] + commands)
    if faulted is None:
        wrong.append(f"{lie}: no fault, drive {min(values):.1f}..{max(values):.1f} N")
    elif values and values[-1] != 0.0:
        wrong.append(f"{lie}: {values[-1]:.1f} N after the fault")
    if over > 0.0:
        wrong.append(f"{lie}: {over:.1f} N beyond the slew limit")
    return wrong, faulted


def lying_cell(folder):
    """The server closes the force loop on a cell that lies: fault and zero within 2 s, and never a
    step beyond the slew limit."""
    lies = ("negative", "alternating", "stuck", "frozen", "wrong_sign", "jumps", "disconnected",
            "drifting")
    boards = [(lie, attempt, Board(lie=lie_of_cell)) for attempt in range(3) for lie in lies]
    wrong, notes, done = [], [], set()
    for lie, attempt, board in boards:
        if lie in done:
            board.end()
            continue
        said = one_lie(lie, board, f"{folder}/{lie}-{attempt}")
        if said is None:
            continue
        done.add(lie)
        wrong += said[0]
        if said[1] is not None:
            notes.append(f"{lie}: fault after {1e3 * said[1]:.0f} ms")
    wrong += [f"{lie}: this host held the board up" for lie in lies if lie not in done]
    return {"wrong": wrong, "notes": notes}


def honest_once(board, folder):
    """What was wrong; None: the host held the board up."""
    daemon = serve(board, folder, LOOP)
    try:
        from calls import Session, stub
        calls = stub(daemon)
        session = Session(calls, device="board")
        if not session.open() or not press(calls, session, 12.0, ("ENGAGED",)):
            return ["no force"]
        board.commands()
        end = time.monotonic() + 4.0
        while time.monotonic() < end and session.state.state == 5:
            session.publish([0.010 + 0.008 * (int(3 * time.monotonic()) % 2)])
            time.sleep(0.010)
        state, over = session.state, steps(board.commands())
        session.end()
    finally:
        daemon.stop()
        board.end()
    if state.faults and state.faults & ~LINK == 0:
        return None
    wrong = [f"state {state.state}, faults {state.faults}"] if state.state != 5 else []
    return wrong + ([f"{over:.1f} N beyond the slew limit"] if over > 0.0 else [])


def honest_cell(folder):
    """The control of lying_cell: a cell that does not lie makes no fault."""
    boards, wrong = [Board(lie=lie_of_cell) for _ in range(4)], None
    for i, board in enumerate(boards):
        if wrong is None:
            wrong = honest_once(board, f"{folder}/{i}")
        else:
            board.end()
    return {"wrong": ["this host held the board up"] if wrong is None else wrong}


def bad_text(folder):
    """Serial number and model with bad UTF-8, ESC, newline, bidi: calls work, the log is clean."""
    wrong = []
    names = (b"\xff\xfe\xfd", b"a\x1b[31mb", b"line\nother", b"\xc2\x9b2J",
             "\u202eevil".encode(), b"%s%n{}")
    boards = [Board({"serial": name, "model": name}) for name in names]
    for i, (name, board) in enumerate(zip(names, boards)):
        daemon = serve(board, f"{folder}/{i}", wait=False)
        try:
            with contextlib.suppress(RuntimeError):
                daemon.wait_served(8.0)
            if daemon.process.poll() is None:
                from calls import outcome, service, stub
                status = outcome(stub(daemon).ListDevices, service.ListDevicesRequest())
                if status != "OK":
                    wrong.append(f"{name!r}: ListDevices {status}")
            log = daemon.log.read_bytes()
            bad = [c for c in (b"\x1b", b"\xc2\x9b", "\u202e".encode(), b"\xff", b"\nother")
                   if c in log]
            if bad:
                wrong.append(f"{name!r}: {bad[0]!r} in the log")
        finally:
            daemon.stop()
            board.end()
    return {"wrong": wrong}


OPENINGS = {
    "version 0": {"version": 0}, "version 2": {"version": 2}, "no DoF": {"n_q": 0},
    "25 DoFs": {"n_q": 25}, "255 DoFs": {"n_q": 255}, "n_a 2": {"n_a": 2}, "n_a 0": {"n_a": 0},
    "n_a 255": {"n_a": 255}, "watchdog 0": {"watchdog": 0}, "watchdog 1 us": {"watchdog": 1},
    "watchdog 71 min": {"watchdog": 2**32 - 1}, "watchdog 1 min": {"watchdog": 60_000_000},
    "period 0": {"period": 0}, "period 71 min": {"period": 2**32 - 1},
    "another session": {"own_session": 7}, "session 0": {"own_session": 0},
}
DICTIONARIES = {
    "no dictionary": [], "index 1": [dof(1)],
    "index 255": [dof(255)], "unit 7": [dof(unit=7)], "radians": [dof(unit=1)],
    "sensed": [dof(actuated=0)], "actuated 2": [dof(actuated=2)],
    "lower above upper": [dof(lower=1.0, upper=-1.0)], "range NaN": [dof(lower=NAN)],
    "range infinite": [dof(upper=INFINITE)], "effort NaN": [dof(effort=NAN)],
    "effort 0": [dof(effort=0.0)], "effort negative": [dof(effort=-50.0)],
    "effort 1": [dof(effort=1.0)], "rate NaN": [dof(rate=NAN)], "rate 0": [dof(rate=0.0)],
    "another name": [dof(name=b"y")], "no name": [dof(name=b"")], "name \\xff": [dof(name=b"\xff")],
    "short frame": [dof()[:-1]], "long frame": [dof() + b"x"],
}


def bad_openings(folder):
    """Boards whose identity or dictionary is wrong: none is ever armed, and hapticd never dies of
    it."""
    wrong, running = [], []
    cases = [(name, fields, None) for name, fields in OPENINGS.items()]
    cases += [(name, {}, dofs) for name, dofs in DICTIONARIES.items()]
    cases.append(("two DoFs", {"n_q": 2}, [dof(), dof_two()]))

    def finish(name, board, daemon):
        if daemon.process.poll() is None and board.hellos.value == 0:
            wrong.append(f"{name}: hapticd never said HELLO")
        if board.armings.value:
            wrong.append(f"{name}: armed")
        daemon.stop()
        if daemon.process.returncode not in (0, 1, 2):
            wrong.append(f"{name}: hapticd ended with {daemon.process.returncode}")
        board.end()
    for begin in range(0, len(cases), 5):
        for i, (name, fields, dofs) in enumerate(cases[begin:begin + 5]):
            board = Board(fields, dofs)
            running.append((name, board, serve(board, f"{folder}/{begin + i}", wait=False)))
        end = time.monotonic() + 2.5
        while time.monotonic() < end and any(
                d.process.poll() is None for _, _, d in running):
            time.sleep(0.05)
        for name, board, daemon in running:
            if daemon.process.poll() is None:  # it serves: an armed board needs a controller
                arm_by_lease(daemon)
            finish(name, board, daemon)
        running = []
    return {"wrong": wrong, "notes": [f"{len(cases)} boards"]}


def arm_by_lease(daemon):
    """A controller's lease, in another process because of gRPC and forks."""
    import subprocess
    import sys
    script = ("import haptic,sys,time\n"
              "with haptic.Connection(sys.argv[1]) as c, c.session(client_name='a', "
              "nominal_rate_hz=50) as s:\n"
              "    for _ in range(150):\n"
              "        s.publish(haptic.FREE); time.sleep(0.02)\n"
              "        if s.state and s.state.state == 'ARMED': break\n")
    with contextlib.suppress(subprocess.TimeoutExpired):
        subprocess.run([sys.executable, "-c", script, daemon.address], timeout=15.0,
                       env={**os.environ, "PYTHONPATH": os.environ["HAPTIC_PYTHON"]},
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def lie_under_force(name, f):
    board, phase = f["board"], f["time"] // 1_000
    changes = {
        "nan_q": {"q": [NAN]}, "infinite_q": {"q": [INFINITE]}, "huge_q": {"q": [3e38]},
        "outside": {"q": [1.5]}, "jumping_q": {"q": [0.9 if phase % 2 else -0.9]},
        "two_q": {"q": [0.0, 0.0]}, "no_q": {"q": []}, "n_q_255": {"n_q": 255},
        "nan_force": {"force": [NAN]}, "no_force": {"force": []}, "n_f_9": {"n_f": 9},
        "state_7": {"state": 7}, "fault": {"state": FAULT, "faults": 31},
        "faults_255": {"faults": 255}, "stopped": {"state": STOPPED},
        "disarmed": {"state": DISARMED}, "other_nonce": {"nonce": 12_345},
        "future_command": {"seq": board.command_seq + 1_000_000},
        "time_0": {"time": 0}, "time_back": {"time": max(0, 10_000_000 - f["time"])},
        "time_leaps": {"time": f["time"] + (2**40 if phase % 2 else 0)},
        "time_last": {"time": 2**64 - 1},
        "unknown_type": {"kind": 0xee}, "as_counters": {"kind": COUNTERS},
        "as_identity": {"kind": IDENTITY},
        "silent": {"raw": b""}, "zeros": {"raw": b"\0" * 400}, "junk": {"raw": b"\xa5" * 400},
        "same_seq": {"raw": frame(STATE, 1, b"x" * 30)},
        "too_long": {"raw": b"\0" + b"\x01" * 3_000 + b"\0"},
        "new_identity": {"raw": frame(IDENTITY, board.seq, identity(board.session, n_q=24))},
        "restart": {"raw": frame(STATE, board.seq + 2**31, struct.pack("<QII", 0, 0, 0))},
    }
    f.update(changes.get(name, {}))


UNDER_FORCE = (
    "nan_q", "infinite_q", "huge_q", "outside", "jumping_q", "two_q", "no_q", "n_q_255",
    "nan_force", "no_force", "n_f_9", "state_7", "fault", "faults_255", "stopped", "disarmed",
    "other_nonce", "future_command", "time_0", "time_back", "time_leaps", "time_last",
    "unknown_type", "as_counters", "as_identity", "silent", "zeros", "junk", "same_seq", "too_long",
    "new_identity", "restart")


def bad_states(folder):
    """What a board may say while it presses: no step of force, and force again afterwards."""
    board = Board(lie=lie_under_force)
    daemon = serve(board, folder)
    wrong = []
    try:
        from calls import Session, stub
        calls = stub(daemon)
        session = Session(calls, device="board")
        session.open()
        for lie in UNDER_FORCE:
            if not press(calls, session, 12.0, ("ENGAGED",)):
                wrong.append(f"before {lie}: no force, state {session.state.state}, "
                             f"faults {session.state.faults}, {session.status}")
                break
            board.commands()
            board.tell(lie)
            press(calls, session, 0.35)
            board.tell("")
            press(calls, session, 0.15)
            over = steps(board.commands())
            if over > 0.0:
                wrong.append(f"{lie}: {over:.1f} N beyond the slew limit")
            if daemon.process.poll() is not None:
                wrong.append(f"{lie}: hapticd ended with {daemon.process.returncode}")
                break
        session.end()
    finally:
        took, status = daemon.stop()
        board.end()
    if status != 0 or took > 5.0:
        wrong.append(f"ended with {status} after {took:.1f} s")
    return {"wrong": wrong[:6], "notes": [f"{len(UNDER_FORCE)} lies"]}


def arms_by_itself(folder):
    """A board that stops under force and then says ARMED again, under the nonce that it had: the
    fault stays, and no force goes out until a person clears it."""
    def lie(name, f):
        if name == "stopped":
            f["state"] = STOPPED
        elif name == "again":
            f["state"], f["board"].state = ARMED, ARMED
        elif name == "early" and f["board"].nonce == 0:
            f["state"], f["nonce"] = ARMED, 4_711
    wrong = []
    board = Board(lie=lie)
    board.tell("early")  # armed before anyone asked
    daemon = serve(board, folder)
    try:
        from calls import Session, stub
        calls = stub(daemon)
        time.sleep(0.5)
        if any(value for _, _, _, value in board.commands()):
            wrong.append("force to a board that said ARMED by itself")
        board.tell("")
        session = Session(calls, device="board")
        session.open()
        if not press(calls, session, 8.0, ("ENGAGED",)):
            return {"wrong": ["no force"]}
        press(calls, session, 0.3)
        armings = board.armings.value
        board.tell("stopped")
        press(calls, session, 0.2)
        board.commands()
        board.tell("again")
        press(calls, session, 1.0)
        force = max((abs(value) for _, _, _, value in board.commands()), default=0.0)
        if session.state.state != 7:
            wrong.append(f"state {session.state.state} after the board stopped and armed itself")
        if force > 0.0:
            wrong.append(f"{force:.1f} N without a clear")
        if board.armings.value != armings:
            wrong.append("armed again without a clear")
        board.tell("")
        if not press(calls, session, 8.0, ("ENGAGED",)):
            wrong.append("no force after a clear")
        session.end()
    finally:
        daemon.stop()
        board.end()
    return {"wrong": wrong}


def arms_twice(folder):
    """Three leases, three armings, three nonces. In the second the board goes on under the nonce of
    the first: that is not armed, and no force goes out."""
    def lie(name, f):
        if name == "former":  # deaf to DISARM and ARM
            f["state"], f["nonce"] = ARMED, f["board"].nonces[0]
    wrong = []
    board = Board(lie=lie)
    daemon = serve(board, folder)
    try:
        from calls import Session, stub
        calls = stub(daemon)
        for lease in range(3):
            session = Session(calls, device="board")
            if not session.open():
                wrong.append(f"lease {lease}: {session.status}")
                break
            if lease == 1:
                board.tell("former")
                board.commands()
                if press(calls, session, 1.5, ("ENGAGING", "ENGAGED")):
                    wrong.append("force while the board is armed for a lease that ended")
                force = max((abs(value) for _, _, _, value in board.commands()), default=0.0)
                if force > 0.0:
                    wrong.append(f"{force:.1f} N to a board that is armed for another lease")
                board.tell("")
            if not press(calls, session, 8.0, ("ENGAGED",)):
                wrong.append(f"lease {lease}: no force")
            session.end()
            time.sleep(0.6)
        nonces = board.nonces()
        if len(nonces) < 3 or len(set(nonces)) != len(nonces) or 0 in nonces:
            wrong.append(f"{len(set(nonces))} nonces for three armings")
    finally:
        daemon.stop()
        board.end()
    return {"wrong": wrong, "notes": [f"{len(nonces)} armings"]}
