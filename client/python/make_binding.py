#!/usr/bin/env python3
"""Writes the module haptic._libhaptic: the functions, structs and constants of the C headers, as
cffi's ABI mode reads them. So they are declared once, and the package needs no compiler.

    make_binding.py OUTPUT HEADER...        what a header includes comes before it
"""

import pathlib
import re
import sys

import cffi
from cffi import recompiler


def declarations(text: str) -> str:
    """The headers without comments, attributes and what the preprocessor does, but for numbers."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S).replace("HAPTIC_API ", "")
    numbers = re.findall(r"^#define \w+ \d+(?= *$)", text, re.M)
    text = re.sub(r"^#ifdef __cplusplus\n.*?^#endif\n", "", text, flags=re.M | re.S)
    return "\n".join(numbers) + re.sub(r"^#.*$", "", text, flags=re.M)


def main() -> None:
    ffi = cffi.FFI()
    ffi.cdef(declarations("\n".join(pathlib.Path(header).read_text() for header in sys.argv[2:])))
    ffi.set_source("haptic._libhaptic", None)
    recompiler.make_py_source(ffi, "haptic._libhaptic", sys.argv[1])


main()
