"""Plane: from the structs of the clients to the numbers that core computes with.

A field goes by its name through all of these. Numbers are copied, checked and given a list of their
own in core by what this writes; lists of numbers, and numbers with the option (placed), have a line
of code in the server. A contact has the fields that contact_at() does not make of its geometry.
"""

from schema import Field, Schema, pascal, wrapped

_MADE = "Made of Plane in proto/haptic/v1/session.proto by proto/generate: nothing to edit here."
_CPP = {"double": "double", "uint32": "std::uint32_t"}
_C = {"double": "double", "uint32": "uint32_t"}
_CSHARP = {"double": "double", "uint32": "uint"}
_LISTS_IN_C = {"normal": "HAPTIC_MAX_COORDINATES", "curvature": "36", "object_direction": "6"}


def _fields(schema: Schema) -> list[Field]:
    return schema.messages["Plane"].fields


def _numbers(schema: Schema) -> list[Field]:
    return [field for field in _fields(schema) if not field.repeated]


def told(schema: Schema) -> list[Field]:
    """What a contact has as well."""
    return [field for field in _fields(schema) if not field.of_geometry]


def _listed(schema: Schema) -> list[Field]:
    return [field for field in _numbers(schema) if not field.placed]


def about(field: Field, contact: bool) -> str:
    notes = field.unit if contact else field.allowed
    return " ".join(filter(None, [field.comment, f"[{notes}]" if notes else ""]))


# The C++ client.


def _cpp_members(fields: list[Field], contact: bool) -> list[str]:
    lines = []
    for field in fields:
        kind = _CPP[field.kind]
        kind = f"std::vector<{kind}>" if field.repeated else kind
        kind = f"std::optional<{kind}>" if field.optional else kind
        start = "0.0" if kind == "double" else "0" if kind == _CPP["uint32"] else ""
        lines += wrapped(about(field, contact), "  /// ")
        lines.append(f"  {kind} {field.name}{{{start}}};")
    return lines


def cpp_plane(schema: Schema) -> list[str]:
    return ["#pragma once", f"// {_MADE}", "", "#include <cstdint>", "#include <optional>",
            "#include <vector>", "", "namespace haptic::client {", "",
            *wrapped(schema.messages["Plane"].comment, "/// "), "struct Plane {",
            *_cpp_members(_fields(schema), False), "};", "", "}  // namespace haptic::client"]


def cpp_contact(schema: Schema) -> list[str]:
    """Members of haptic::client::Contact, to be included in it."""
    return [f"  // {_MADE}", *_cpp_members(told(schema), True)]


def cpp_conversion(schema: Schema) -> list[str]:
    lines = [f"// {_MADE}", '#include "convert.hpp"', '#include "told.hpp"', "",
             "namespace haptic::client {", "", "void write(const Plane& from, v1::Plane& to) {"]
    for field in _fields(schema):
        got = f"from.{field.name}"
        if field.repeated:
            lines.append(f"  to.mutable_{field.name}()->Add({got}.begin(), {got}.end());")
        elif field.optional:
            lines.append(f"  if ({got}) to.set_{field.name}(*{got});")
        else:
            lines.append(f"  to.set_{field.name}({got});")
    lines += ["}", "", "void tell(const Contact& from, double coupling, Plane& to) {"]
    for field in told(schema):
        by = " / coupling" if field.by_coupling else ""
        lines.append(f"  to.{field.name} = from.{field.name}{by};")
    return lines + ["}", "", "}  // namespace haptic::client"]


# The values that cross from the front to the owner, and core's.


def crossing(schema: Schema) -> list[str]:
    """Members of haptic::server::PlaneSample, to be included in it."""
    lines = [f"  // {_MADE}"]
    for field in sorted(_numbers(schema), key=lambda field: field.kind != "double"):
        lines.append(f"  {_CPP[field.kind]} {field.name}{{0}};")
    return lines + [f"  std::uint32_t tells_{field.name}{{0}};  ///< 0: it does not"
                    for field in _numbers(schema) if field.optional]


def front(schema: Schema) -> list[str]:
    lines = [f"// {_MADE}", '#include "server/front/session/plane_fields.hpp"', "",
             "namespace haptic::server {", "",
             "void read_fields(const v1::Plane& from, PlaneSample& to) {"]
    for field in _numbers(schema):
        lines.append(f"  to.{field.name} = from.{field.name}();")
        if field.optional:
            lines.append(f"  to.tells_{field.name} = from.has_{field.name}() ? 1 : 0;")
    return lines + ["}", "", "}  // namespace haptic::server"]


def _is_allowed(field: Field) -> str:
    """The condition, of `value`, that (allowed) says."""
    words = field.allowed.removeprefix("0 or ")
    low, high = (f"-{words[2:]}", words[2:]) if words.startswith("+-") else words.split("..")
    try:
        within = f"value >= {float(low)!r} && value <= {float(high)!r}"
    except ValueError:
        raise SystemExit(f'Plane.{field.name}: (allowed) = "{field.allowed}", must be "LOW..HIGH", '
                         '"+-HIGH" or "0 or LOW..HIGH"') from None
    return within if words == field.allowed else f"value == 0.0 || ({within})"


_WRITE_LIST = """\
namespace {

/// A list of size 0 if no plane has the number; with `tells`, if a plane does not tell it.
template <typename Number>
void write_list(const ProxySample& sample, Number PlaneSample::*number,
                std::uint32_t PlaneSample::*tells, core::PlaneSet::Offsets& to) {
  const std::span planes(sample.planes.data(), sample.plane_count);
  const auto told = [&](const PlaneSample& p) { return p.*tells != 0; };
  const auto some = [&](const PlaneSample& p) { return flushed(p.*number) != 0.0; };
  const bool has = tells != nullptr ? std::ranges::all_of(planes, told)
                                    : std::ranges::any_of(planes, some);
  to.resize(has ? static_cast<Eigen::Index>(planes.size()) : 0);
  for (Eigen::Index i = 0; i < to.size(); ++i) {
    to[i] = flushed(planes[static_cast<std::size_t>(i)].*number);
  }
}

}  // namespace""".splitlines()


def owner(schema: Schema) -> list[str]:
    lines = [f"// {_MADE}", '#include "server/owner/ingress/plane_fields.hpp"', "",
             "#include <algorithm>", "#include <span>", "",
             '#include "server/owner/ingress/ingress.hpp"',
             '#include "server/owner/ingress/refused.hpp"', "", "namespace haptic::server {", "",
             *_WRITE_LIST, "",
             "std::optional<Verdict> check_fields(const PlaneSample& plane, std::size_t p) {"]
    for field in _numbers(schema):
        if not field.allowed:
            if field.kind == "double":
                raise SystemExit(f"Plane.{field.name}: needs (allowed), what the server takes")
            continue
        told = f"plane.tells_{field.name} != 0 && " if field.optional else ""
        must = "be" if field.allowed.startswith("0 or") else "lie within"
        allowed = field.allowed.replace("0 or ", "0 or lie within ")
        lines += [f"  if (const double value = plane.{field.name};",
                  f"      {told}!({_is_allowed(field)})) {{",
                  "    return refused(IngressVerdict::kBadPlane,",
                  f'        "planes[{{}}].{field.name} = {{:.6g}}: must {must} {allowed}",',
                  "        p, value);",
                  "  }"]
    lines += ["  return {};", "}", "",
              "void write_fields(const ProxySample& sample, core::PlaneSet& to) {"]
    for field in _listed(schema):
        told = f"&PlaneSample::tells_{field.name}" if field.optional else "nullptr"
        lines.append(f"  write_list(sample, &PlaneSample::{field.name}, {told}, to.{field.name});")
    return lines + ["}", "", "}  // namespace haptic::server"]


def core(schema: Schema) -> list[str]:
    """Members of haptic::core::PlaneSet, to be included in it."""
    lines = [f"  // {_MADE}"]
    for field in _listed(schema):
        lines += wrapped(about(field, False), "  /// ")
        lines.append(f"  Offsets {field.name}{{}};")
    names = ", ".join(field.name for field in _listed(schema))
    return lines + ["  [[nodiscard]] auto lists() const noexcept {",
                    *wrapped(f"return std::tie({names});", "    ", "        "), "  }"]


# C.


def _c_members(fields: list[Field], contact: bool) -> list[str]:
    lines = []
    for field in sorted(fields, key=lambda field: field.number):
        words = about(field, contact)
        lines += wrapped(words, "  /* ", "   * ", " */") if words else []
        if field.repeated:
            if not field.axis:
                lines.append(f"  uint32_t {field.name}_count;")
            lines.append(f"  {_C[field.kind]} {field.name}[{_LISTS_IN_C[field.name]}];")
        else:
            if field.optional:
                lines.append(f"  int32_t has_{field.name}; /* 0: the next is absent */")
            lines.append(f"  {_C[field.kind]} {field.name};")
    return lines


def c_header(schema: Schema) -> list[str]:
    return ["#ifndef HAPTIC_HAPTIC_PLANE_H", "#define HAPTIC_HAPTIC_PLANE_H", f"/* {_MADE}",
            " * haptic_contact.h includes this. */", "#include <haptic/haptic_point.h>", "",
            *wrapped(schema.messages["Plane"].comment, "/* ", " * ", " */"),
            "typedef struct haptic_plane {", "  size_t size;",
            *_c_members(_fields(schema), False), "} haptic_plane;", "",
            "/* A point of the tool against an object. */", "typedef struct haptic_contact {",
            "  size_t size;", "  haptic_point point;  /* its size too must be set */",
            "  double normal[3];    /* of the object at the nearest point, outwards */",
            "  double gap;          /* from the object to the point along the normal, m; < 0: "
            "inside */", "  double curvature[6]; /* of the object; haptic_sphere_curvature() */",
            "  double stiffness;    /* of point and object in series, N/m; 0: rigid */",
            *_c_members(told(schema), True), "} haptic_contact;", "", "#endif"]


def _c_reader(name: str, struct: str, called: str, fields: list[Field]) -> list[str]:
    lines = ["", f"void read_fields(const {struct}& from, client::{name}& to) {{"]
    for field in fields:
        got, to = f"from.{field.name}", f"to.{field.name}"
        if field.repeated:
            lines += [f'  at_most("{called}{field.name}_count", {got}_count, std::size({got}));',
                      f"  {to}.assign({got}, {got} + {got}_count);"]
        else:
            when = f"if ({'from.has_' + field.name} != 0) " if field.optional else ""
            lines.append(f"  {when}{to} = {got};")
    return lines + ["}"]


def c_conversion(schema: Schema) -> list[str]:
    plane = [field for field in _fields(schema) if not field.axis]
    lines = [f"// {_MADE}", '#include "convert_plane.hpp"', "", "namespace haptic::c {",
             *_c_reader("Plane", "haptic_plane", "plane.", plane),
             *_c_reader("Contact", "haptic_contact", "contact->", told(schema)), "",
             "void write_fields(const client::Plane& from, haptic_plane& to) {"]
    for field in plane:
        got, to = f"from.{field.name}", f"to.{field.name}"
        if field.repeated:
            lines.append(f"  {to}_count = write_values({got}, {to});")
        elif field.optional:
            lines += [f"  to.has_{field.name} = {got}.has_value();",
                      f"  {to} = {got}.value_or({_CPP[field.kind]}{{}});"]
        else:
            lines.append(f"  {to} = {got};")
    return lines + ["}", "", "}  // namespace haptic::c"]


# C#.


def _csharp_members(fields: list[Field], contact: bool) -> list[str]:
    lines = []
    for field in fields:
        kind = _CSHARP[field.kind] + ("[]" if field.repeated else "?" if field.optional else "")
        empty = f" = new {_CSHARP[field.kind]}[0]" if field.repeated else ""
        lines += wrapped(about(field, contact), "  /// ")
        lines.append(f"  public {kind} {pascal(field.name)}{empty};")
    return lines


def csharp(schema: Schema) -> list[str]:
    writes = []
    for field in _fields(schema):
        got = f"from.{pascal(field.name)}"
        if field.optional:
            writes.append(f"    if ({got}.HasValue) to.Present({field.number}, {got}.Value);")
        else:
            kind = {"double": "Real", "uint32": "Number"}[field.kind] + "s" * field.repeated
            writes.append(f"    to.{kind}({field.number}, {got});")
    tells = [f"    to.{pascal(field.name)} = from.{pascal(field.name)}"
             f"{' / coupling' if field.by_coupling else ''};" for field in told(schema)]
    return [f"// {_MADE}", "namespace Haptic {", "",
            *wrapped(schema.messages["Plane"].comment, "/// "), "public sealed class HapticPlane {",
            *_csharp_members(_fields(schema), False), "}", "",
            "public sealed partial class Contact {", *_csharp_members(told(schema), True), "",
            "  internal static void Tell(Contact from, double coupling, HapticPlane to) {",
            *(line.replace("    ", "    ", 1) for line in tells), "  }", "}", "",
            "public sealed partial class HapticSession {",
            "  static Message Of(HapticPlane from) {", "    var to = new Message();", *writes,
            "    return to;", "  }", "}", "", "}  // namespace Haptic"]


KINDS = {
    "cpp_plane": cpp_plane,            # client::Plane
    "cpp_contact": cpp_contact,        # what client::Contact has of it
    "cpp_plane_convert": cpp_conversion,  # to v1::Plane, and contact_at()'s part of it
    "crossing": crossing,              # the numbers of server::PlaneSample
    "front": front,                    # v1::Plane -> these
    "ingress": owner,                  # their check, and their way to core::PlaneSet
    "core": core,                      # the lists of core::PlaneSet
    "c_plane": c_header,               # haptic_plane and haptic_contact
    "c_plane_convert": c_conversion,   # from and to client::Plane and client::Contact
    "csharp_plane": csharp,            # HapticPlane, and what Contact has of it
}
