"""Copies the messages of a state and of contacts, and declares fields more: two in DeviceState, one
in Plane.

    add_field.py PROTO OUTPUT

PROTO: the folder proto/; OUTPUT: gets haptic/v1/session.proto and what it imports.
"""

import pathlib
import sys

FIELDS = {"DeviceState": '''
  // Declared by a test alone.
  double tested = 1000 [(unit) = "N", (from) = "life.gain"];
  // One per actuator.
  repeated double tested_list = 1001
      [(axis) = AXIS_ACTUATED, (unit) = "EFFORT", (from) = "effort.tau_a"];
''', "Plane": '''
  // How strongly the surface holds a point that leaves it. Declared by a test alone.
  double stickiness = 1000 [(unit) = "N", (allowed) = "0..5", (by_coupling) = true];
'''}


def main() -> None:
    source, output = (pathlib.Path(folder) / "haptic/v1" for folder in sys.argv[1:])
    output.mkdir(parents=True, exist_ok=True)
    options = (source / "field_options.proto").read_text(encoding="utf-8")
    session = (source / "session.proto").read_text(encoding="utf-8")
    for message, fields in FIELDS.items():
        before, begin, rest = session.partition(f"\nmessage {message} {{\n")
        declared, end, after = rest.partition("\n}\n")
        assert begin and end, f"session.proto has no message {message}"
        session = before + begin + declared + fields + end + after
    (output / "field_options.proto").write_text(options, encoding="utf-8")
    (output / "session.proto").write_text(session, encoding="utf-8")


main()
