"""Leases: taken, guessed, resumed, filled up, given away by stops."""

import threading
import time


def observers(daemon):
    """Forty observers without credentials; a controller must find a place all the same."""
    from calls import OBSERVER, Session, controls, stub
    held, refused = [], 0
    for i in range(40):
        session = Session(stub(daemon), role=OBSERVER, client_name=f"observer {i}",
                          state_rate_hz=1.0)
        if session.open(1.0):
            held.append(session)
        else:
            refused += 1
    newcomer = controls(stub(daemon), device="spare")
    wrong = []
    if newcomer != "OK":
        wrong.append(f"a controller of the free device was refused: {newcomer}")
    for session in held:
        session.end()
    return {"wrong": wrong, "notes": [f"{len(held)} observers in, {refused} refused"]}


def former_controllers(daemon):
    """Seventy controllers of the spare device that are taken from and stay: each leaves its place
    to the next."""
    from calls import OPERATOR, PRIMARY, Session, controls, stub
    held, got = [], 0
    for i in range(70):
        session = Session(stub(daemon), device="spare", client_name=f"former {i}",
                          priority=OPERATOR if i % 2 else PRIMARY, state_rate_hz=1.0)
        got += session.open(3.0)
        held.append(session)
        if i % 2:
            session.end()  # so that the next one may have it
    newcomer = controls(stub(daemon), device="spare", priority=OPERATOR)
    wrong = [] if newcomer == "OK" else [f"a controller was refused: {newcomer}"]
    for session in held:
        session.end()
    return {"wrong": wrong, "notes": [f"{got} of 70 had it"]}


def watches(daemon):
    """Three hundred watches at every tick that are never read."""
    from frames import (DATA, END_HEADERS, END_STREAM, HEADERS, SERVICE, Peer, call, frame, message)
    import struct
    request = message(b"\x0a\x06finger\x11" + struct.pack("<d", 1000.0))
    peers = []
    for _ in range(30):
        peer = Peer(daemon.tcp, polite=False)
        for _ in range(10):
            number = peer.stream()
            peer.send(frame(HEADERS, END_HEADERS, number, call(SERVICE + "Watch")) +
                      frame(DATA, END_STREAM, number, request))
        peers.append(peer)
    time.sleep(2.5)
    for peer in peers:
        peer.socket.close()
    return {"notes": ["300 watches of 1000 Hz, unread"]}


def preemption(daemon):
    """Operators that take the finger from each other, a hundred times; some leave at once."""
    from calls import OPERATOR, PRIMARY, Session, stub
    calls, granted = stub(daemon), 0
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        weak = Session(calls, client_name="weak", priority=PRIMARY)
        strong = Session(calls, client_name="strong", priority=OPERATOR)
        granted += strong.open(1.0)
        strong.publish()
        weak.end()
        strong.end()
    return {"notes": [f"{granted} times taken"]}


def ten_operators(daemon):
    """Ten at once: one gets it, nine hear who has it."""
    from calls import OPERATOR, Session, stub
    sessions = [Session(stub(daemon), client_name=f"operator {i}", priority=OPERATOR)
                for i in range(10)]
    results = [None] * 10

    def try_it(i):
        results[i] = sessions[i].open(3.0)
    threads = [threading.Thread(target=try_it, args=(i,)) for i in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    wrong = [] if sum(map(bool, results)) == 1 else [f"{sum(map(bool, results))} of ten got it"]
    for session in sessions:
        session.end()
    return {"wrong": wrong}


def theft(daemon):
    """At the same priority and below, fifty times: never."""
    from calls import TEST, controls, stub
    calls, wrong = stub(daemon), []
    for i in range(50):
        status = controls(calls, name="thief", priority=TEST if i % 2 else 0, seconds=1.0)
        if status != "ALREADY_EXISTS":
            wrong.append(f"theft {i}: {status}")
            break
    return {"wrong": wrong}


def guessed_resume(daemon):
    """Resumes under guessed ids, and under the id of an observer: never the finger."""
    from calls import OBSERVER, Session, stub
    calls, wrong = stub(daemon), []
    observer = Session(calls, role=OBSERVER)
    observer.open()
    for guess in ("0" * 32, "f" * 32, "x" * 5_000, "", observer.opened.session_id):
        session = Session(calls, client_name="thief", resume=guess, resumable=True)
        if session.open(1.0):
            wrong.append(f"resumed as '{guess[:8]}'")
        session.end()
    observer.end()
    return {"wrong": wrong}


def spare_session(calls, **more):
    from calls import Session
    session = Session(calls, device="spare", **more)
    session.open(2.0)
    return session


def six_resumes(daemon):
    """Six resumes of one session at once: exactly one goes on."""
    from calls import Session, stub
    calls, wrong = stub(daemon), []
    for _ in range(5):
        first = spare_session(calls, resumable=True)
        if first.opened is None:
            wrong.append(f"no session: {first.status}")
            break
        first.publish([0.0])
        time.sleep(0.05)
        sessions = [Session(stub(daemon), device="spare", client_name=f"again {i}",
                            resume=first.opened.session_id, resumable=True) for i in range(6)]
        threads = [threading.Thread(target=s.open, args=(2.0,)) for s in sessions]
        for thread in threads:
            thread.start()
        first.call.cancel()
        for thread in threads:
            thread.join()
        resumed = sum(1 for s in sessions if s.opened is not None and s.opened.resumed)
        if resumed > 1:
            wrong.append(f"{resumed} of six resumed")
        for session in sessions:
            if session.opened is not None:
                from calls import wire
                session.queue.put(wire.SessionRequest(leave=wire.LeaveSession()))
            session.end()
        time.sleep(0.1)
    return {"wrong": wrong}


def resume_silent(daemon):
    """Resumes again and again without a sample: the lease must end at its time all the same."""
    from calls import stub
    calls = stub(daemon)
    session = spare_session(calls, resumable=True)
    began, count, wrong = time.monotonic(), 0, []
    while time.monotonic() < began + 4.0:
        session.call.cancel()
        again = spare_session(calls, resumable=True, resume=session.opened.session_id)
        if again.opened is None:
            wrong.append(f"no session: {again.status}")
            break
        session = again
        if not session.opened.resumed:
            break
        count += 1
        time.sleep(0.1)
    else:
        wrong.append("the lease was kept alive for 4 s without a sample")
    session.end()
    return {"wrong": wrong, "notes": [f"{count} resumes in {time.monotonic() - began:.1f} s"]}


class Streaming:
    """A session of the finger whose samples keep coming, through resumes."""

    def __init__(self, calls):
        from calls import OPERATOR, Session
        self.calls, self.make = calls, lambda **more: Session(
            calls, priority=OPERATOR, resumable=True, state_rate_hz=250.0, **more)
        self.session, self.running = self.make(), True
        self.ok = self.session.open()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while self.running:
            self.session.publish((0.4, 0.5236))
            time.sleep(0.010)

    def state(self):
        from calls import wire
        state = self.session.state
        return wire.DeviceStateName.Name(state.state)[18:] if state else ""

    def becomes(self, states, seconds, gain=0.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.state() in states and self.session.state.gain >= gain:
                return True
            time.sleep(0.002)
        return False

    def end(self):
        from calls import wire
        self.running = False
        self.thread.join()
        self.session.queue.put(wire.SessionRequest(leave=wire.LeaveSession()))
        time.sleep(0.3)
        self.session.end()


def resume_while_engage_pends(daemon):
    """A resume while an Engage waits for its tick. An Engage that was refused then must not act: no
    force without one that was granted."""
    from calls import grpc, service, stub
    calls, wrong, granted, refused, reasons = stub(daemon), [], 0, 0, set()
    streaming = Streaming(calls)
    if not streaming.ok:
        return {"wrong": [f"no session: {streaming.session.status}"]}
    time.sleep(0.4)
    end, tries = time.monotonic() + 12.0, 0
    while time.monotonic() < end and len(wrong) < 3:
        tries += 1
        old = streaming.session
        id_ = old.opened.session_id
        ask = service.EngageRequest(session_id=id_)
        if tries % 2:  # the resume must come between an Engage and the tick that answers it
            pending = [calls.Engage.future(ask) for _ in range(1 + tries % 3)]
            again = streaming.make(resume=id_)
        else:
            again = streaming.make(resume=id_)
            time.sleep(0.0002 * (tries % 7))
            pending = [calls.Engage.future(ask) for _ in range(2)]
        if not again.open(2.0):
            wrong.append(f"resume {tries}: {again.status}")
            break
        streaming.session = again
        answers = []
        for call in pending:
            try:
                call.result(timeout=2.0)
                answers.append("")
            except grpc.FutureTimeoutError:
                wrong.append("an Engage was never answered")
            except grpc.RpcError as error:
                answers.append(error.details() or "refused")
        if not again.opened.resumed:
            wrong.append(f"resume {tries} was an ordinary opening")
        old.call.cancel()
        # A tick may begin before the Release that takes it back; nothing is felt of that.
        force = streaming.becomes(("ENGAGING", "ENGAGED"), 0.080, gain=0.15)
        if "" in answers:
            granted += 1
        else:
            refused += 1
            reasons.add(answers[0][:40])
            if force:
                wrong.append(f"an Engage acted that was refused: {answers[0][:60]}")
        if force or "" in answers:
            with_id = service.ReleaseRequest(session_id=again.opened.session_id)
            calls.Release(with_id, timeout=2.0)
            if not streaming.becomes(("ARMED",), 2.0):
                wrong.append(f"no end of force after Release: {streaming.state()}")
    streaming.end()
    return {"wrong": wrong, "notes": [f"{granted} granted, {refused} refused",
                                          *sorted(reasons)]}


def stops_and_clears(daemon):
    """Stops and clears of every device for 3 s, with Engage between."""
    from calls import outcome, service, stub
    calls, rounds, wrong, end = stub(daemon), 0, [], time.monotonic() + 3.0
    while time.monotonic() < end:
        status = outcome(calls.EmergencyStop, service.EmergencyStopRequest())
        if status != "OK":
            wrong.append(f"stop: {status}")
        for device in ("finger", "spare"):
            outcome(calls.ClearFault, service.ClearFaultRequest(device=device))
        outcome(calls.Engage, service.EngageRequest(session_id="0" * 32))
        rounds += 1
    for device in ("finger", "spare"):
        outcome(calls.ClearFault, service.ClearFaultRequest(device=device))
    return {"wrong": wrong[:3], "notes": [f"{rounds} rounds"]}


def clear_by_stranger(daemon):
    """Clears of faults that are not there, or that do not exist; a stop stays latched."""
    from calls import outcome, service, stub
    calls, wrong = stub(daemon), []
    for ids in ([0], [32], [2**32 - 1], [1] * 10_000, list(range(1, 32))):
        status = outcome(calls.ClearFault,
                         service.ClearFaultRequest(device="finger", fault_ids=ids))
        if status not in ("OK", "INVALID_ARGUMENT"):
            wrong.append(f"ClearFault {ids[:2]}: {status}")
    return {"wrong": wrong}


def clock_jump(daemon):
    """A source clock that jumps by 73 years, both ways, under force; slew 5e-324; then silence."""
    from calls import OPERATOR, Session, outcome, service, stub
    calls = stub(daemon)
    session = Session(calls, priority=OPERATOR)
    if not session.open():
        return {"wrong": [f"no session: {session.status}"]}
    years = 73 * 365 * 86_400 * 10**9

    def stream(seconds, offset):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            seq = session.state.seq if session.state else 0
            session.publish((0.4, 0.5236), device_seq_used=seq,
                            source_time_ns=max(1, time.monotonic_ns() + offset))
            time.sleep(0.010)
    stream(0.6, 0)
    status = outcome(calls.Engage, service.EngageRequest(session_id=session.opened.session_id))
    for offset in (years, 0, years, -years, 10**9, -(10**9)):
        stream(0.3, offset)
    slew = outcome(calls.UpdateSettings, service.UpdateSettingsRequest(
        session_id=session.opened.session_id, slew_limit=[5e-324]))
    stream(0.3, 0)
    time.sleep(0.6)  # silent: force must be gone whatever the slew limit is
    session.end()
    return {"notes": [f"Engage: {status}", f"slew: {slew}"]}
