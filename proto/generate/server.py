"""The server: from the record of a tick to v1::DeviceState, and from v1::Plane to the numbers that
core computes with.

State. The option (from) of a field says where its value is. In DeviceState that is a path in
core::TickRecord, or "owner.NAME" for the function NAME of server/owner/state/values.hpp. In a
message that DeviceState holds it is a path in the part of the record that this message is from;
the message is present if that part's member `on` is true.

Plane. A field goes by its name all the way. Numbers are copied, checked and given a list of their
own in core by what this writes; lists of numbers, and numbers with the option (placed), have a line
of code in the server.
"""

from cpp import TYPES, source
from schema import MADE, Field, Message, Schema, wrapped


def _value(field: Field, message: Message) -> str:
    if not field.source:
        raise SystemExit(f"{message.name}.{field.name}: needs (from): where the owner has it "
                         "at the end of a tick")
    if message.name != "DeviceState":
        return f"from.{field.source}"
    of_owner = field.source.removeprefix("owner.")
    return f"from.record.{field.source}" if of_owner == field.source else f"{of_owner}(from)"


def _write(field: Field, message: Message) -> str:
    value = _value(field, message)
    if field.kind == "message":
        return (f"  if ({value}.on) {{\n    write({value}, *to.mutable_{field.name}());\n"
                f"  }} else {{\n    to.clear_{field.name}();\n  }}")
    if field.repeated:
        return f"  put({value}, *to.mutable_{field.name}());"
    plain = f"plain({value})"
    if field.kind == "enum":
        plain = f"static_cast<v1::{field.type}>({value})"
    return f"  to.set_{field.name}({plain});"


def write_state(schema: Schema) -> list[str]:
    body = []
    for message in schema.state:
        top = message.name == "DeviceState"
        kind = "const TickTold&" if top else "const auto&"
        local = "" if top else "static "
        body += ["", f"{local}void write({kind} from, v1::{message.name}& to) {{",
                 *(_write(field, message) for field in message.fields), "}"]
    return source(['#include "server/owner/state/state_message.hpp"',
                   '#include "server/owner/state/values.hpp"'], "haptic::server", body)


def _numbers(schema: Schema) -> list[Field]:
    return [field for field in schema.plane.fields if not field.repeated]


def _listed(schema: Schema) -> list[Field]:
    return [field for field in _numbers(schema) if not field.placed]


def crossing(schema: Schema) -> list[str]:
    """Members of haptic::server::PlaneSample, to be included in it."""
    lines = [f"  // {MADE}"]
    for field in sorted(_numbers(schema), key=lambda field: field.kind != "double"):
        lines.append(f"  {TYPES[field.kind]} {field.name}{{0}};")
    return lines + [f"  std::uint32_t tells_{field.name}{{0}};  ///< 0: it does not"
                    for field in _numbers(schema) if field.optional]


def front(schema: Schema) -> list[str]:
    body = ["", "void read_fields(const v1::Plane& from, PlaneSample& to) {"]
    for field in _numbers(schema):
        body.append(f"  to.{field.name} = from.{field.name}();")
        if field.optional:
            body.append(f"  to.tells_{field.name} = from.has_{field.name}() ? 1 : 0;")
    return source(['#include "server/front/session/plane_fields.hpp"'], "haptic::server",
                  body + ["}"])


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


def ingress(schema: Schema) -> list[str]:
    body = ["", *_WRITE_LIST, "",
            "std::optional<Verdict> check_fields(const PlaneSample& plane, std::size_t p) {"]
    for field in _numbers(schema):
        if not field.allowed:
            if field.kind == "double":
                raise SystemExit(f"Plane.{field.name}: needs (allowed), what the server takes")
            continue
        told = f"plane.tells_{field.name} != 0 && " if field.optional else ""
        must = "be" if field.allowed.startswith("0 or") else "lie within"
        allowed = field.allowed.replace("0 or ", "0 or lie within ")
        body += [f"  if (const double value = plane.{field.name};",
                 f"      {told}!({_is_allowed(field)})) {{",
                 "    return refused(IngressVerdict::kBadPlane,",
                 f'        "planes[{{}}].{field.name} = {{:.6g}}: must {must} {allowed}",',
                 "        p, value);",
                 "  }"]
    body += ["  return {};", "}", "",
             "void write_fields(const ProxySample& sample, core::PlaneSet& to) {"]
    for field in _listed(schema):
        told = f"&PlaneSample::tells_{field.name}" if field.optional else "nullptr"
        body.append(f"  write_list(sample, &PlaneSample::{field.name}, {told}, to.{field.name});")
    return source(['#include "server/owner/ingress/plane_fields.hpp"', "", "#include <algorithm>",
                   "#include <span>", "", '#include "server/owner/ingress/ingress.hpp"',
                   '#include "server/owner/ingress/refused.hpp"'], "haptic::server", body + ["}"])


def core(schema: Schema) -> list[str]:
    """Members of haptic::core::PlaneSet, to be included in it."""
    lines = [f"  // {MADE}"]
    for field in _listed(schema):
        lines += [*wrapped(field.of_plane(), "  /// "), f"  Offsets {field.name}{{}};"]
    names = ", ".join(field.name for field in _listed(schema))
    return lines + ["  [[nodiscard]] auto lists() const noexcept {",
                    *wrapped(f"return std::tie({names});", "    ", "        "), "  }"]


KINDS = {
    "owner": write_state,  # core::TickRecord -> v1::DeviceState
    "crossing": crossing,  # the numbers of server::PlaneSample
    "front": front,        # v1::Plane -> these
    "ingress": ingress,    # their check, and their way to core::PlaneSet
    "core": core,          # the lists of core::PlaneSet
}
