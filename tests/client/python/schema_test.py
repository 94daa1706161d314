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
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from haptic._library import new
from hapticd_process import Hapticd, eventually

FILES = descriptor_pb2.FileDescriptorSet.FromString(
    pathlib.Path(os.environ["HAPTIC_DESCRIPTORS"]).read_bytes())
POOL = descriptor_pool.DescriptorPool()
for file in FILES.file:
    POOL.Add(file)
STATE = POOL.FindMessageTypeByName("haptic.v1.DeviceState")
OPTIONS = message_factory.MessageFactory(POOL).GetPrototype(
    POOL.FindMessageTypeByName("google.protobuf.FieldOptions"))
DOFS, COORDINATES = ["l_x", "q_B"], ["q_o1_mcp", "q_o2_pip"]  # of finger_constant
LABELS = {0: [], 1: DOFS, 2: DOFS[:1], 3: COORDINATES}  # by AXIS_DOF, _ACTUATED, _COORDINATE


def option(field, name):
    options = OPTIONS.FromString(field.GetOptions().SerializeToString())
    return options.Extensions[POOL.FindExtensionByName("haptic.v1." + name)]


def called(field):
    """Its name in the client libraries."""
    return option(field, "called") or field.name


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
            yield prefix + field.name, option(field, "axis")


class Types(unittest.TestCase):
    def test_python_has_every_field(self) -> None:
        for message in messages():
            made = getattr(haptic, message.name).__dataclass_fields__
            names = [called(field) for field in message.fields]
            names = [name[:-2] + "s" if name.endswith("_us") else name for name in names]
            self.assertEqual(list(made), names, message.name)

    def test_values_are_named_without_prefix(self) -> None:
        c = new("haptic_state")
        c.state, c.proxy_age_us, c.staleness = 5, 2500, 77
        c.q.count, c.q.value[0] = 1, 0.5
        c.tracker.present, c.tracker.seq_used = 1, 3
        state = haptic.DeviceState.of(c)
        self.assertEqual((state.state, state.mode, state.staleness), ("ENGAGED", "NONE", "77"))
        self.assertEqual((state.proxy_age_s, state.q, state.tracker.seq_used), (0.0025, (0.5,), 3))
        self.assertIsNone(state.passivity)

    def test_a_plane_goes_to_c_and_back(self) -> None:
        plane, values = POOL.FindMessageTypeByName("haptic.v1.Plane"), {}
        for field in plane.fields:
            repeated = field.label == field.LABEL_REPEATED
            whole = field.cpp_type == field.CPPTYPE_UINT32
            value = field.number if whole else field.number + 0.5
            values[field.name] = (value, value + 1.0) if repeated else value
        told, c = haptic.Plane(**values), new("haptic_plane")
        told.fill(c)
        self.assertEqual(haptic.Plane.of(c, 2), told)


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
            if field.label != field.LABEL_REPEATED or getattr(state, called(field), ()):
                if not field.message_type or getattr(state, called(field)):
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
