"""The client against a running hapticd."""

import os
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from collections.abc import Callable

import haptic
from hapticd_process import Hapticd, eventually
from one_server import OneServer, reasons_until

EXAMPLES = os.path.join(os.environ["HAPTIC_SCENES"], "../../client/python/examples")


class Facts(OneServer):
    def test_device_and_server(self) -> None:
        device, = self.connection.devices()
        self.assertEqual(device.name, "finger")
        self.assertEqual([d.actuated for d in device.dofs], [True, False])
        self.assertEqual(len(device.coordinates), 2)
        self.assertEqual(device.force_limit, (25.0,))
        self.assertEqual(self.connection.server_info().scene, "one finger at rest")

    def test_watch_yields_states_until_left(self) -> None:
        states = self.connection.watch(rate_hz=100)
        first, second = (next(s for s in states if isinstance(s, haptic.DeviceState)) for _ in "ab")
        self.assertGreater(second.seq, first.seq)
        states.close()


class Force(OneServer):
    def test_it_ramps_up_and_is_released(self) -> None:
        session = self.open()
        session.engage_when_ready()
        state = self.hold(session, lambda s: s.state == "ENGAGED")
        self.assertEqual(state.gain, 1.0)
        self.assertEqual(state.carrier, "GRPC")
        session.release()
        self.hold(session, lambda s: s.state == "ARMED" and s.gain == 0.0)
        self.assertIn("ENGAGING -> ENGAGED", reasons_until(session, "RELEASING -> ARMED"))

    def test_release_ends_the_asking(self) -> None:
        session = self.open()
        session.engage_when_ready()  # there are no samples yet, so it waits
        session.release()
        self.hold(session, lambda s: s.proxy_seq_used > 50,
                  lambda: self.assertIn(session.state.state if session.state else "ARMED",
                                        {"IDLE", "ARMED"}))

    def test_a_fault_ends_the_asking_even_if_it_is_cleared(self) -> None:
        session = self.open()
        session.engage_when_ready()  # there are no samples yet, so it waits
        self.connection.emergency_stop()
        self.connection.clear_fault()
        reasons_until(session, "FAULT -> IDLE")
        self.assertTrue(eventually(lambda: session.state and session.state.state == "ARMED"))
        self.hold(session, lambda s: s.proxy_seq_used > 50,
                  lambda: self.assertEqual(session.state.gain, 0.0))
        refusal = session.engage_refusal
        assert refusal is not None
        self.assertIn("EMERGENCY_STOP", refusal.message)

    def test_what_it_waits_for_is_said(self) -> None:
        session = self.open()
        self.assertIsNone(session.engage_refusal)
        session.engage_when_ready()
        self.assertTrue(eventually(lambda: session.engage_refusal is not None))
        self.assertIn(session.engage_refusal.reason,
                      {"NOT_ARMED", "STREAM_STALE", "TOO_FEW_SAMPLES", "STREAM_TOO_YOUNG"})
        self.hold(session, lambda s: s.state == "ENGAGED")
        self.assertIsNone(session.engage_refusal)

    def test_silence_ends_it_with_an_event(self) -> None:
        session = self.open()
        session.engage_when_ready()
        self.hold(session, lambda s: s.state == "ENGAGED")
        self.assertTrue(eventually(lambda: session.state.staleness == "LOST"))
        self.assertEqual(session.wait_for_state().tau_elastic, (0.0,))
        events: list[haptic.Event] = []

        def lost() -> bool:
            events.extend(session.events())
            return {"LOST", "FADE -> LOST"} <= {e.reason for e in events}

        self.assertTrue(eventually(lost))
        levels = [e.reason for e in events if e.kind == "STALENESS"]
        self.assertEqual(levels[-3:], ["FRESH -> HOLD", "HOLD -> FADE", "FADE -> LOST"])

    def test_refusals_have_the_servers_reason(self) -> None:
        session = self.open()
        with self.assertRaises(haptic.ClientError) as refused:
            session.engage()
        self.assertIn(refused.exception.reason, {"NOT_ARMED", "STREAM_STALE", "TOO_FEW_SAMPLES"})
        with self.assertRaises(haptic.ClientError) as refused:
            self.connection.session(client_name="second", nominal_rate_hz=60)
        self.assertEqual(refused.exception.reason, "LEASE_HELD")
        self.assertIn("test", str(refused.exception))
        self.assertEqual(str(pickle.loads(pickle.dumps(refused.exception))),
                         str(refused.exception))

    def test_what_c_cannot_hold_is_refused(self) -> None:
        for call, kind in ((lambda: self.connection.clear_fault("finger", [32]), OverflowError),
                           (lambda: self.connection.healthy("finger\0x"), ValueError),
                           (lambda: self.connection.session(client_name="a",
                                                            nominal_rate_hz=0), ValueError)):
            with self.assertRaises(kind):
                call()

    def test_a_wrong_sample_is_named(self) -> None:
        session = self.open()
        with self.assertRaisesRegex(haptic.ClientError, "count = 3, must be 2"):
            session.publish(haptic.held([0.1, 0.2, 0.3]))
        with self.assertRaisesRegex(ValueError, r"planes\[1\].normal: has 1 values, must have 2"):
            session.publish(haptic.behind([((1.0, 0.0), 0.3), ((1.0,), 0.3)], (0.0, 0.0)))
        # The server counts, and names, what only it can judge.
        session.publish(haptic.behind([((0.0, 0.0), 0.3)], (0.0, 0.0)))
        self.assertTrue(eventually(lambda: session.statistics().rejected_invalid == 1))
        self.assertIn("planes[0].normal", session.statistics().last_rejection)

    def test_the_deepest_planes_are_sent(self) -> None:
        session = self.open()
        x_probe = session.wait_for_state().x_probe
        planes = [((1.0, 0.0), x_probe[0] + (0.1 if i < 8 else -0.1)) for i in range(40)]
        session.publish(haptic.behind(planes, x_probe))
        self.assertTrue(eventually(lambda: session.statistics().accepted == 1))
        self.assertEqual(session.statistics().planes_left_out, 8)
        self.assertTrue(eventually(lambda: session.wait_for_state().active_planes & 1 == 1))

    def test_the_round_trip_is_measured(self) -> None:
        session = self.open()
        self.assertEqual(session.round_trip_s, 0.0)
        session.publish(haptic.FREE)
        self.assertTrue(eventually(lambda: session.round_trip_s > 0.0))
        self.assertLess(session.round_trip_s, 30.0)

    def test_contacts_are_taken(self) -> None:
        session = self.open()
        x_probe = session.wait_for_state().x_probe
        # 0.1 inside the object, which gives way by three quarters of that.
        law = dict(compliance=3.0, velocity=0.0, curvature=(0.0, 0.0, 1.0))
        session.publish(haptic.behind(
            [haptic.contact(x_probe, -0.1, (-1.0, 0.0), **law)], x_probe))
        self.assertTrue(eventually(lambda: session.wait_for_state().active_planes & 1 == 1))
        # With an id the position is the client's own proxy: it says that nothing is touched.
        session.publish(haptic.behind(
            [haptic.contact(x_probe, -0.1, (-1.0, 0.0), id=1, mass=1e-4, damping=1e-3,
                            ground_stiffness=0.2, load=0.0, **law)], x_probe))
        self.assertTrue(eventually(lambda: session.wait_for_state().active_planes == 0))
        self.assertEqual(session.statistics().rejected_invalid, 0)

    def test_the_error_is_bounded(self) -> None:
        session = self.open()
        state = session.wait_for_state()
        self.assertEqual(len(state.error_bound), 0)
        # The client's own proxy: 0.1 inside, and three quarters of that with the object.
        x = (state.x_probe[0] - 0.025, state.x_probe[1])
        session.publish(haptic.behind([haptic.contact(
            x, -0.075, (-1.0, 0.0), compliance=3.0, id=1, uncertainty=0.1)], x))
        self.assertTrue(eventually(lambda: len(session.wait_for_state().error_bound) > 0))

    def test_settings_are_clamped_with_a_reason(self) -> None:
        session = self.open()
        applied = session.update_settings(stiffness=[1e6], renderer="SUBSPACE_EXACT")
        self.assertEqual(applied.stiffness, (1500.0,))
        self.assertEqual(applied.renderer, "SUBSPACE_EXACT")
        self.assertEqual(len(applied.clamped), 1)
        self.assertIn("stiffness[0]", applied.clamped[0])
        self.assertTrue(session.update_settings(direction_guard=True).direction_guard)
        with self.assertRaisesRegex(ValueError, "'EXACT', must be one of .*SUBSPACE_EXACT"):
            session.update_settings(renderer="EXACT")

    def test_an_emergency_stop_needs_no_session(self) -> None:
        self.assertEqual(self.connection.emergency_stop(), ["finger"])
        self.assertEqual(self.connection.clear_fault("finger", [7, 7]), [7])


class Session(OneServer):
    def test_leaving_gives_the_lease_back(self) -> None:
        with self.connection.session(client_name="first", nominal_rate_hz=60):
            self.assertEqual(self.connection.devices()[0].controller, "first")
        with self.connection.session(client_name="second", nominal_rate_hz=60):
            self.assertEqual(self.connection.devices()[0].controller, "second")

    def test_a_higher_priority_takes_the_device(self) -> None:
        low = self.open(priority=haptic.Priority.TEST)
        self.open(client_name="operator", priority=haptic.Priority.OPERATOR)
        self.assertIn("LEASE_PREEMPTED", reasons_until(low, "LEASE_PREEMPTED"))

    def test_a_held_proxy_is_sent_as_contacts(self) -> None:
        session = self.open(derive_planes=True, blocks=[(0, 2)])
        session.engage_when_ready()
        self.hold(session, lambda s: s.gain > 0)
        beyond = self.hold_beyond(session, lambda s: s.mode == "PLANES")
        self.assertEqual(beyond.active_planes, 1)

    def hold_beyond(self, session: haptic.Session,
                    until: Callable[[haptic.DeviceState], bool]) -> haptic.DeviceState:
        state = session.wait_for_state()
        latest = time.monotonic() + 20
        while not until(state) and time.monotonic() < latest:
            session.publish(haptic.held((state.x_probe[0] - 0.01, state.x_probe[1])))
            state = session.wait_for_state()
        return state

    def test_an_observer_may_not_engage(self) -> None:
        session = self.open(observer=True)
        session.wait_for_state()
        with self.assertRaises(haptic.ClientError) as refused:
            session.engage()
        self.assertEqual(refused.exception.reason, "NOT_CONTROLLER")

    def test_calls_after_the_end_raise(self) -> None:
        session = self.open()
        session.close()
        session.close()  # idempotent
        for call in (lambda: session.publish(haptic.FREE), session.wait_for_state, session.events,
                     session.engage, lambda: session.state):
            with self.assertRaises(haptic.ClientError) as refused:
                call()
            self.assertEqual(refused.exception.reason, "CLOSED")

    def test_a_server_that_dies_is_told(self) -> None:
        session = self.open()
        session.wait_for_state()
        self.server.stop()
        with self.assertRaisesRegex(haptic.ClientError, "the session ended: "):
            for _ in range(10000):
                session.wait_for_state()
        told: list[haptic.Event] = []

        def ended() -> bool:  # the event may come after the error
            told.extend(session.events())
            return ("DISCONNECTED", "ENDED") in [(event.kind, event.state) for event in told]

        self.assertTrue(eventually(ended), told)
        with self.assertRaisesRegex(haptic.ClientError, "the session ended: "):
            session.publish(haptic.FREE)


class Reconnecting(OneServer):
    def test_a_new_front_is_found_and_force_goes_on(self) -> None:
        session = self.open(reconnect=True, re_engage=True)
        session.engage_when_ready()
        epoch = self.hold(session, lambda s: s.state == "ENGAGED").lease_epoch
        subprocess.run([os.environ["HAPTICCTL"], "--server", self.server.address, "restart-front"],
                       check=True, timeout=60)
        seen: list[haptic.Event] = []
        self.hold(session, lambda s: any(e.reason in ("LEASE_RESUMED", "LEASE_GRANTED")
                                         for e in seen if e.kind == "LEASE" and lost(seen)),
                  lambda: seen.extend(session.events()))
        self.assertIn("RECONNECTING", [e.state for e in seen])
        state = self.hold(session, lambda s: s.state == "ENGAGED")
        self.assertGreater(state.lease_epoch, epoch)
        self.assertTrue(session.connected)


def lost(events: list[haptic.Event]) -> bool:
    return any(e.kind == "DISCONNECTED" for e in events)


class OverTls(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.key, self.certificate = (os.path.join(folder.name, name) for name in ("key", "cert"))
        subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
             "-nodes", "-keyout", self.key, "-out", self.certificate, "-subj", "/CN=hapticd",
             "-addext", "subjectAltName=IP:127.0.0.1", "-days", "1"],
            check=True, capture_output=True, timeout=60)
        self.server = Hapticd("finger_constant", tcp=True, settings=(
            f'server.tls={{certificate: "{self.certificate}" key: "{self.key}"}}',))
        self.addCleanup(self.server.stop)

    def test_a_session_works(self) -> None:
        tls = haptic.Tls(ca_file=self.certificate)
        with haptic.Connection(self.server.address, tls=tls) as connection:
            with connection.session(client_name="secret", nominal_rate_hz=60) as session:
                self.assertGreater(session.wait_for_state().seq, 0)

    def test_another_authority_is_not_believed(self) -> None:
        with haptic.Connection(self.server.address, tls=haptic.Tls()) as connection:
            with self.assertRaises(haptic.ClientError) as refused:
                connection.devices()
        self.assertEqual(refused.exception.reason, "UNREACHABLE")

    def test_a_missing_file_is_named(self) -> None:
        with self.assertRaisesRegex(haptic.ClientError, "no/such.pem"):
            haptic.Connection(self.server.address, tls=haptic.Tls(ca_file="no/such.pem"))

    def test_the_readmes_client_works(self) -> None:
        code = readme_code(2)
        for told, here in (("robot:29470", self.server.address), ("issuer.pem", self.certificate),
                           ("while True", "for _ in range(180)")):
            self.assertIn(told, code)
            code = code.replace(told, here)
        run = subprocess.run([sys.executable, "-c", code + "print(state.state)"],
                             capture_output=True, text=True, timeout=60)
        self.assertEqual((run.returncode, run.stdout), (0, "ENGAGED\n"), run.stderr)

    def test_the_example_holds_the_wall(self) -> None:
        output = subprocess.run(
            [sys.executable, os.path.join(EXAMPLES, "wall.py"), "--server", self.server.address,
             "--ca", self.certificate, "--seconds", "4"],
            check=True, capture_output=True, text=True, timeout=60).stdout
        self.assertIn("ENGAGED", output)


class Udp(OneServer):
    udp = True

    def test_samples_go_by_udp(self) -> None:
        session = self.open()
        session.engage_when_ready()
        state = self.hold(session, lambda s: s.state == "ENGAGED" and s.carrier == "UDP")
        self.assertTrue(session.statistics().udp_in_use)
        self.assertEqual(state.gain, 1.0)
        reasons_until(session, "SAMPLES GRPC -> UDP")

    def test_it_can_be_left_out(self) -> None:
        session = self.open(carriers=haptic.Carriers.STREAM)
        self.hold(session, lambda s: s.proxy_seq_used > 50)
        self.assertFalse(session.statistics().udp_in_use)


class Addresses(unittest.TestCase):
    """The UDP path goes to the stream's host, however the address is written."""

    def test_each_form_reaches_the_udp_port(self) -> None:
        server = Hapticd("finger_constant", udp=True, tcp=True)
        self.addCleanup(server.stop)
        port = server.address.rpartition(":")[2]
        for host in ("127.0.0.1", "localhost", "ipv4:127.0.0.1", "dns:127.0.0.1",
                     "dns:///127.0.0.1"):
            with self.subTest(host), haptic.Connection(f"{host}:{port}") as connection:
                with connection.session(client_name="form", nominal_rate_hz=60) as session:
                    def by_udp() -> bool:
                        session.publish(haptic.FREE)
                        return session.wait_for_state().carrier == "UDP"

                    self.assertTrue(eventually(by_udp))


class Examples(unittest.TestCase):
    def test_the_wall_holds(self) -> None:
        server = Hapticd("finger_constant")
        self.addCleanup(server.stop)
        said = subprocess.run(
            [sys.executable, os.path.join(EXAMPLES, "wall.py"), "--server", server.address,
             "--seconds", "4"], check=True, capture_output=True, text=True, timeout=60).stdout
        lines = said.splitlines()
        self.assertIn("ENGAGED", lines[-1])
        force = float(lines[-1].split(",")[2].removesuffix("N"))
        # The hand wants 0.52 rad, the wall stands at 0.3: the actuator pushes back.
        self.assertLess(force, -1.0)

    def test_two_devices_feel_each_other_if_the_scene_allows(self) -> None:
        led_force = []
        for power in 0, 1:
            leading = Hapticd("finger_soft_grasp")
            led = Hapticd("finger_constant", settings=[
                f"device[0].passivity.tank={{allowed_power_w: {power}}}"])
            self.addCleanup(leading.stop)
            self.addCleanup(led.stop)
            said = subprocess.run(
                [sys.executable, os.path.join(EXAMPLES, "couple_two_devices.py"), "--server",
                 leading.address, "--other", led.address, "--seconds", "8"],
                check=True, capture_output=True, text=True, timeout=60).stdout
            found = re.findall(r"^second: mean force +([0-9.]+), held back", said, re.MULTILINE)
            led_force.append(sum(map(float, found[3:])))
        # On a busy machine the first second of motion is another one: how far apart is not judged.
        self.assertGreater(led_force[1], 1.5 * led_force[0], "a moving proxy gives out energy")

    def test_the_grasp_is_felt_after_a_pause_too(self) -> None:
        server = Hapticd("finger_soft_grasp", patient=False)
        self.addCleanup(server.stop)
        with haptic.Connection(server.address) as connection:
            told = connection.watch()
            next(told)  # from now on no event is missed
            client = subprocess.Popen(
                [sys.executable, os.path.join(EXAMPLES, "soft_grasp.py"), "--server",
                 server.address, "--seconds", "8"], stdout=subprocess.PIPE, text=True)
            self.addCleanup(client.wait)
            self.addCleanup(client.kill)
            events = (e for e in told if isinstance(e, haptic.Event))
            next(e for e in events if e.reason == "ARMED -> ENGAGING")
            client.send_signal(signal.SIGSTOP)
            next(e for e in events if e.kind == "LOST")
            client.send_signal(signal.SIGCONT)
        output, _ = client.communicate(timeout=60)
        self.assertIn("touching", output)
        peak = float(output.split("largest elastic force ")[1].split(" ")[0])
        self.assertGreater(peak, 0.5)


def readme_code(number: int) -> str:
    readme = os.path.join(os.environ["HAPTIC_SCENES"], "../../client/README.md")
    with open(readme, encoding="utf-8") as page:
        return page.read().split("```python\n")[number].split("```")[0]


class Readme(unittest.TestCase):
    def test_its_first_client_works(self) -> None:
        code = readme_code(1)
        self.assertIn('"127.0.0.1:29470"', code)
        self.assertLessEqual(len(code.splitlines()), 20)
        server = Hapticd("finger_constant")
        self.addCleanup(server.stop)
        with haptic.Connection(server.address) as connection:
            code = code.replace("127.0.0.1:29470", server.address)
            client = subprocess.Popen([sys.executable, "-c", code])
            self.addCleanup(client.kill)
            latest = time.monotonic() + 30
            # The hand wants 0.52 rad, the wall stands at 0.3: the actuator pushes back.
            states = (s for s in connection.watch(rate_hz=200) if isinstance(s, haptic.DeviceState))
            felt = next(s for s in states if time.monotonic() > latest or
                        s.state == "ENGAGED" and s.tau_elastic[0] < -1.0)
            self.assertEqual(felt.state, "ENGAGED")
            self.assertEqual(client.wait(timeout=30), 0)


if __name__ == "__main__":
    unittest.main()
