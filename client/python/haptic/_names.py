"""Names of enum values."""

from __future__ import annotations

from typing import Any


def name_of(enum_type: Any, value: int) -> str:
    """"ENGAGED" of DEVICE_STATE_NAME_ENGAGED; "NONE" of an UNSPECIFIED; the number of a value that
    only a newer server knows."""
    known = enum_type.DESCRIPTOR.values_by_number.get(value)
    if known is None:
        return str(value)
    # "StalenessLevel" precedes its values as "STALENESS_LEVEL_": one more character per capital.
    type_name = enum_type.DESCRIPTOR.name
    name = str(known.name)[len(type_name) + sum(map(str.isupper, type_name)):]
    return "NONE" if name == "UNSPECIFIED" else name
