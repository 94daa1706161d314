"""Writes one file of a program from the messages, while it is built.

    python3 proto/generate KIND DESCRIPTORS OUTPUT

DESCRIPTORS: what protoc --descriptor_set_out --include_imports --include_source_info makes of
haptic/v1/haptic_service.proto; haptic/v1/session.proto is enough for states and planes. KIND: one
of KINDS.
"""

import pathlib
import sys

import c
import cpp
import csharp
import python
import server
from schema import Schema

KINDS = {**server.KINDS, **cpp.KINDS, **c.KINDS, **csharp.KINDS, **python.KINDS}


def main() -> None:
    if len(sys.argv) != 4 or sys.argv[1] not in KINDS:
        sys.exit(f"usage: generate {'|'.join(KINDS)} DESCRIPTORS OUTPUT")
    kind, descriptors, output = sys.argv[1:]
    schema = Schema(pathlib.Path(descriptors).read_bytes())
    text, file = "\n".join(KINDS[kind](schema)) + "\n", pathlib.Path(output)
    if not file.exists() or file.read_text(encoding="utf-8") != text:  # spares compilers work
        file.write_text(text, encoding="utf-8")


main()
