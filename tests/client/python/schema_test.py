"""Every field of v1::DeviceState's descriptor is in Python's DeviceState, in `hapticctl watch` as a
table and as JSON, and in a recording."""

import csv
import json
import os
import pathlib
import pty
import subprocess
import tempfile
import unittest

import haptic
from haptic.v1 import field_options_pb2 as options
from haptic.v1 import session_pb2 as wire
from hapticd_process import Hapticd, eventually

STATE = wire.DeviceState.DESCRIPTOR
DOFS, COORDINATES = ["l_x", "q_B"], ["q_o1_mcp", "q_o2_pip"]  # of finger_constant
LABELS = {0: [], options.AXIS_DOF: DOFS, options.AXIS_ACTUATED: DOFS[:1],
          options.AXIS_COORDINATE: COORDINATES}


def messages(message=STATE):
    """The descriptor and those of the messages in it."""
    yield message
    for field in message.fields:
        if field.message_type:
            yield from messages(field.message_type)


def leaves(message=STATE, prefix=""):
    """Name and axis of every field that holds values."""
    for field in message.fields:
        if field.message_type and field.label != field.LABEL_REPEATED:
            yield from leaves(field.message_type, field.name + "_")
        else:
            yield prefix + field.name, field.GetOptions().Extensions[options.axis]


class Types(unittest.TestCase):
    def test_python_has_every_field(self) -> None:
        for message in messages():
            made = getattr(haptic, message.name).__dataclass_fields__
            names = [field.name for field in message.fields]
            names = [name[:-2] + "s" if name.endswith("_us") else name for name in names]
            self.assertEqual(list(made), names, message.name)

    def test_values_are_named_without_prefix(self) -> None:
        state = haptic.DeviceState.of(wire.DeviceState(
            state=wire.DEVICE_STATE_NAME_ENGAGED, proxy_age_us=2500, q=[0.5], staleness=77,
            tracker=wire.TrackerState(seq_used=3)))
        self.assertEqual((state.state, state.mode, state.staleness), ("ENGAGED", "NONE", "77"))
        self.assertEqual((state.proxy_age_s, state.q, state.tracker.seq_used), (0.0025, (0.5,), 3))
        self.assertIsNone(state.passivity)


class Programs(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.recording = pathlib.Path(folder.name, "run.csv")
        self.server = Hapticd("finger_constant", settings=(
            f'record={{file: "{self.recording}"}}', "device[0].unguarded={}"))
        self.addCleanup(self.server.stop)

    def hapticctl(self, *arguments: str) -> list[str]:
        return [os.environ["HAPTICCTL"], "--server", self.server.address, *arguments]

    def test_json_has_every_field(self) -> None:
        run = subprocess.run(self.hapticctl("watch", "--json", "--seconds", "1"), check=True,
                             capture_output=True, text=True)
        state = json.loads(run.stdout.splitlines()[-1])
        self.assertEqual({f.name for f in STATE.fields} - set(state), set())
        for field in STATE.fields:
            if field.message_type and field.label != field.LABEL_REPEATED and state[field.name]:
                self.assertEqual(set(state[field.name]),
                                 {inner.name for inner in field.message_type.fields})
        info = subprocess.run(self.hapticctl("info", "--json"), check=True, capture_output=True,
                              text=True)
        device, = json.loads(info.stdout)["devices"]
        said = {field["name"]: field for field in device["state_fields"]}
        self.assertEqual(list(said), [f.name for f in STATE.fields])
        self.assertEqual(device["unguarded"], ["energy_tank"])  # the scene names the guard
        self.assertEqual((said["tau_a"]["labels"], said["tau_a"]["units"]), (["l_x"], ["N"]))

    def test_table_has_every_present_field(self) -> None:
        screen, terminal = pty.openpty()
        subprocess.run(self.hapticctl("watch", "--seconds", "1"), check=True, stdout=terminal)
        os.close(terminal)
        table = ""
        try:
            while data := os.read(screen, 1 << 16):
                table += data.decode()
        except OSError:  # the end of a terminal
            pass
        os.close(screen)
        with haptic.Connection(self.server.address) as connection:
            state = next(s for s in connection.watch() if isinstance(s, haptic.DeviceState))
        for field in STATE.fields:
            if field.label != field.LABEL_REPEATED or getattr(state, field.name, ()):
                if not field.message_type or getattr(state, field.name):
                    self.assertIn(field.name, table)
        for name in DOFS + COORDINATES:
            self.assertIn(name, table)

    def test_recording_has_every_field(self) -> None:
        self.assertTrue(eventually(lambda: self.recording.read_text().count("\n") > 100))
        rows = self.recording.read_text().splitlines()
        header, row = next(csv.reader(rows)), next(csv.DictReader(rows))
        for name, axis in leaves():
            for label in LABELS[axis] or [""]:
                wanted = label if name == "q" else "_".join(filter(None, [name, label]))
                found = [c for c in header if c == wanted or c.startswith(wanted + "_")]
                self.assertTrue(found, wanted)
        self.assertEqual(row["passivity_tank_j"], "")


if __name__ == "__main__":
    unittest.main()
