"""Writes one file of a program from the messages, while it is built.

    python3 proto/generate KIND DESCRIPTORS OUTPUT

DESCRIPTORS: what protoc --descriptor_set_out --include_imports --include_source_info makes of
haptic/v1/session.proto. KIND: one of KINDS.
"""

import pathlib
import sys

import c
import cpp
import csharp
import owner
import planes
import python
from schema import Schema

KINDS = {
    "owner": owner.write_state,           # core::TickRecord -> v1::DeviceState
    "cpp": cpp.state_header,              # client::DeviceState
    "cpp_convert": cpp.state_conversion,  # to and from v1::DeviceState
    "c": c.state_header,                  # haptic_state
    "c_convert": c.state_conversion,      # client::DeviceState -> haptic_state
    "python": python.messages,            # DeviceState and Plane, from and to the C structs
    "csharp": csharp.state,               # DeviceState, and how it is read
    **planes.KINDS,
}


def main() -> None:
    if len(sys.argv) != 4 or sys.argv[1] not in KINDS:
        sys.exit(f"usage: generate {'|'.join(KINDS)} DESCRIPTORS OUTPUT")
    kind, descriptors, output = sys.argv[1:]
    schema = Schema(pathlib.Path(descriptors).read_bytes())
    pathlib.Path(output).write_text("\n".join(KINDS[kind](schema)) + "\n", encoding="utf-8")


main()
