#!/usr/bin/env python3
"""Writes the messages with one more field of a contact, and all that proto/generate makes of them.

    new_field.py PROTOC FOLDER

FOLDER/proto has the messages, FOLDER/include what C++ includes, FOLDER/*.cpp what it compiles.
"""

import pathlib
import shutil
import subprocess
import sys

FIELD = """
  // How strongly the surface holds a point that leaves it. This field is of a test.
  double stickiness = 1000 [(unit) = "N", (allowed) = "0..5", (by_coupling) = true];
"""
OUTPUTS = {
    "cpp_plane": "include/haptic/client/plane.hpp",
    "cpp_contact": "include/haptic/client/contact_fields.inc",
    "cpp_plane_convert": "convert_plane.cpp",
    "crossing": "include/server/crossing/plane_fields.inc",
    "front": "front_plane.cpp",
    "ingress": "owner_plane.cpp",
    "core": "include/haptic/core/contacts/plane_lists.inc",
    "csharp_plane": "HapticPlane.cs",
}


def main() -> None:
    protoc, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    source = pathlib.Path(__file__).resolve().parents[2] / "proto"
    proto = folder / "proto"
    shutil.copytree(source / "haptic", proto / "haptic", dirs_exist_ok=True)
    session = proto / "haptic/v1/session.proto"
    before, name, after = session.read_text("utf-8").partition("message Plane {\n")
    fields, end, rest = after.partition("\n}\n")
    session.write_text(before + name + fields + FIELD + end + rest, encoding="utf-8")
    for path in OUTPUTS.values():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
    messages = [str(proto / "haptic/v1" / f"{name}.proto") for name in ("session", "field_options")]
    subprocess.run([protoc, f"--cpp_out={folder}/include", "-I", str(proto), *messages], check=True)
    descriptors = folder / "session.binpb"
    subprocess.run([protoc, f"--descriptor_set_out={descriptors}", "--include_imports",
                    "--include_source_info", "-I", str(proto), messages[0]], check=True)
    for kind, path in OUTPUTS.items():
        subprocess.run([sys.executable, "-B", str(source / "generate"), kind, str(descriptors),
                        str(folder / path)], check=True)


main()
