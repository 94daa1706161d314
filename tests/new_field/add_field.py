"""Copies the messages of a state, and declares two fields more in DeviceState.

    add_field.py PROTO OUTPUT

PROTO: the folder proto/; OUTPUT: gets haptic/v1/session.proto and what it imports.
"""

import pathlib
import sys

FIELDS = '''
  // Declared by a test alone.
  double tested = 1000 [(unit) = "N", (from) = "life.gain"];
  // One per actuator.
  repeated double tested_list = 1001
      [(axis) = AXIS_ACTUATED, (unit) = "EFFORT", (from) = "effort.tau_a"];
}
'''


def main() -> None:
    source, output = (pathlib.Path(folder) / "haptic/v1" for folder in sys.argv[1:])
    output.mkdir(parents=True, exist_ok=True)
    options = (source / "field_options.proto").read_text(encoding="utf-8")
    before, begin, rest = (source / "session.proto").read_text(encoding="utf-8").partition(
        "\nmessage DeviceState {\n")
    fields, end, after = rest.partition("\n}\n")
    (output / "field_options.proto").write_text(options, encoding="utf-8")
    (output / "session.proto").write_text(before + begin + fields + FIELDS + after,
                                          encoding="utf-8")
    assert begin and end, "session.proto has no message DeviceState"


main()
