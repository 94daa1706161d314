#include "table.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "commands.hpp"
#include "convert_state.hpp"
#include "haptic/schema/fields.hpp"
#include "message_json.hpp"
#include "say.hpp"

namespace haptic::ctl {

namespace {

namespace pb = google::protobuf;
using schema::effort_unit;

/// Value `index` as "0.0123 m", with five digits: enough for people. A unit that ends the field's
/// name is not said again.
std::string shown(const pb::Message& message, const pb::FieldDescriptor& field, int index,
                  const schema::Label& label = {}) {
  std::string value;
  schema::append_value(message, field, index, value);
  if (field.options().HasExtension(v1::bits) && value.empty()) value = "none";
  const bool fraction =
      value.find('.') != std::string::npos || value.find("e-") != std::string::npos;
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE && fraction) {
    value = text("%.5g", std::strtod(value.c_str(), nullptr));
  }
  const std::string unit = schema::unit_of(field, label);
  return value + (unit.empty() || field.name().ends_with("_" + unit) ? "" : " " + unit);
}

schema::Labels labels_of(const client::DeviceInfo& device) {
  schema::Labels labels;
  for (const auto& dof : device.dofs) labels.add_dof({dof.name, dof.unit}, dof.actuated);
  for (const auto& c : device.coordinates) labels.coordinates.push_back({c.name, c.unit});
  return labels;
}

v1::Axis axis_of(const pb::FieldDescriptor& field) {
  return field.options().GetExtension(v1::axis);
}

/// Appends the items to the last row; an item that would go beyond `width` begins a further row.
void add_items(const Rows& items, std::size_t width, Rows& rows) {
  for (const std::string& item : items) {
    if (rows.back().size() + item.size() + 2 > width) rows.emplace_back("  ");
    rows.back() += "  " + item;
  }
}

/// "gain 0.5" of every value without an axis.
Rows scalars(const pb::Message& message) {
  Rows items;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.GetDescriptor()->field(i);
    if (field.is_repeated() || field.message_type() != nullptr) continue;
    items.push_back(field.name() + " " + shown(message, field, 0));
  }
  return items;
}

/// "slide 0.125 m" of every value along an axis.
Rows labelled(const pb::Message& message, const pb::FieldDescriptor& field,
              const std::vector<schema::Label>& labels) {
  Rows items;
  const int count = message.GetReflection()->FieldSize(message, &field);
  for (int i = 0; i < count && i < static_cast<int>(labels.size()); ++i) {
    const schema::Label& label = labels[static_cast<std::size_t>(i)];
    items.push_back(label.name + " " + shown(message, field, i, label));
  }
  return items;
}

double at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : std::nan("");
}

/// "proxy FRESH, age 1.2 ms"; without a sample there is no age.
std::string age(const char* of, std::uint64_t seq, client::Staleness staleness,
                std::chrono::microseconds age) {
  if (seq == 0) return std::string("no ") + of;
  return text("%s %s, age %.1f ms", of, client::name(staleness),
              static_cast<double>(age.count()) * 1e-3);
}

/// "K slide 1500 -> 820 N/m: proxy held, 50 ms old", of the actuator that is derated most; empty:
/// none is, or there is no force.
std::string derated(const client::DeviceInfo& device, const client::DeviceState& s) {
  static constexpr const char* kWords[]{"", "device's samples", "proxy held,",
                                        "planes that change,"};
  const auto reason = static_cast<std::size_t>(s.derating);
  if (reason == 0 || reason >= std::size(kWords) || !(s.gain > 0.0)) return {};
  std::string words;
  double least = 1.0;
  std::size_t actuated = 0;
  for (const auto& dof : device.dofs) {
    if (!dof.actuated) continue;
    const double whole = at(device.stiffness_limit, actuated);
    const double share = at(s.stiffness_in_effect, actuated++) / s.gain / whole;
    if (!(share < least)) continue;
    least = share;
    words = text("K %s %.4g -> %.4g %s/%s: %s %.0f ms old", dof.name, whole, share * whole,
                 effort_unit(dof.unit), dof.unit, kWords[reason],
                 static_cast<double>(s.derating_delay.count()) * 1e-3);
  }
  return words;
}

/// The limits that act, in words.
Rows limits(const client::DeviceState& s) {
  return schema::bit_words(
      *v1::DeviceState::descriptor()->FindFieldByNumber(v1::DeviceState::kLimitersFieldNumber),
      s.limiters);
}

nlohmann::json schema_of(const pb::Descriptor& type, const schema::Labels& labels) {
  static constexpr const char* kAxes[]{"", "dof", "actuated", "coordinate"};
  nlohmann::json list = nlohmann::json::array();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    nlohmann::json& entry = list.emplace_back(nlohmann::json{{"name", field.name()}});
    if (field.message_type() != nullptr) {
      entry["fields"] = schema_of(*field.message_type(), labels);
    } else if (field.is_repeated()) {
      entry["axis"] = kAxes[axis_of(field)];
      entry["labels"] = entry["units"] = nlohmann::json::array();
      for (const schema::Label& label : labels.of(axis_of(field))) {
        entry["labels"].push_back(label.name);
        entry["units"].push_back(schema::unit_of(field, label));
      }
    } else if (const std::string unit = schema::unit_of(field); !unit.empty()) {
      entry["unit"] = unit;
    }
  }
  return list;
}

}  // namespace

Rows table(const client::DeviceInfo& device, const client::DeviceState& s, double seconds,
           std::uint64_t conflated, std::size_t width) {
  v1::DeviceState message;
  client::write(s, message);
  const pb::Reflection& reflection = *message.GetReflection();
  const schema::Labels labels = labels_of(device);
  Rows rows{text("%s  t %.1f s  conflated %llu", device.name, seconds,
                 static_cast<unsigned long long>(conflated))};
  add_items(scalars(message), width, rows);
  if (const std::string words = derated(device, s); !words.empty()) rows.push_back("  " + words);
  for (const std::string& words : limits(s)) {
    rows.emplace_back(" ");
    std::istringstream all(words);
    for (std::string word; all >> word;) {
      if (rows.back().size() + word.size() + 1 > width) rows.emplace_back("   ");
      rows.back() += " " + word;
    }
  }
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.GetDescriptor()->field(i);
    if (field.is_repeated() && reflection.FieldSize(message, &field) > 0) {
      rows.push_back(text("  %-20s", field.name()));
      add_items(labelled(message, field, labels.of(axis_of(field))), width, rows);
    } else if (field.message_type() != nullptr && reflection.HasField(message, &field)) {
      rows.push_back("  " + field.name() + ":");
      add_items(scalars(reflection.GetMessage(message, &field)), width, rows);
    }
  }
  return rows;
}

std::string line(const client::DeviceInfo& device, const client::DeviceState& s, double seconds) {
  std::string all =
      text("%9.3f s  %s  %-9s %s  gain %.2f ", seconds, device.name, client::name(s.state),
           age("proxy", s.proxy_seq_used, s.staleness, s.proxy_age), s.gain);
  std::string forces;
  std::size_t actuated = 0;
  for (std::size_t i = 0; i < device.dofs.size(); ++i) {
    const auto& dof = device.dofs[i];
    all += text(" %s %8.5f %s", dof.name, at(s.q, i), dof.unit);
    if (!dof.actuated) continue;
    forces += text("  tau_a %s %7.3f %s", dof.name, at(s.tau_a, actuated), effort_unit(dof.unit));
    if (actuated < s.error_bound.size()) forces += text(" +-%.3f", s.error_bound[actuated]);
    ++actuated;
  }
  all += forces;
  if (s.tracker) {
    all += "  " + age("pose", s.tracker->seq_used, s.tracker->staleness, s.tracker->age);
  }
  if (const std::string words = derated(device, s); !words.empty()) all += "  " + words;
  for (const std::string& words : limits(s)) all += "  " + words;
  return all + "  faults " + joined(client::fault_names(s.faults));
}

nlohmann::json state_json(const client::DeviceInfo& device, const client::DeviceState& state) {
  v1::DeviceState message;
  client::write(state, message);
  nlohmann::json all = to_json(message);
  all["device"] = device.name;
  return all;
}

nlohmann::json json_fields(const client::DeviceInfo& device) {
  return schema_of(*v1::DeviceState::descriptor(), labels_of(device));
}

std::string loop_row(const client::ServerInfo& server) {
  return text("loop: %llu ticks, %llu skipped, late %.1f us p50, %.1f us p99; tick %.2f us p50",
              static_cast<unsigned long long>(server.loop.ticks),
              static_cast<unsigned long long>(server.loop.skipped), server.loop.lateness_p50_us,
              server.loop.lateness_p99_us, server.loop.tick_p50_us);
}

std::size_t Screen::width() {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  // A row that wraps would be two, and the next refresh would land below the last.
  return (known ? size.ws_col : 80) - 1;
}

void Screen::show(const Rows& rows) {
  if (shown_ > 0) say("\x1b[%zuA", shown_);
  for (const std::string& row : rows) say("%s\x1b[K\n", wire::printable(row).substr(0, width()));
  // Fewer rows than before leave some of them below: they are erased.
  if (rows.size() < shown_) say("\x1b[J");
  std::fflush(stdout);
  shown_ = rows.size();
}

}  // namespace haptic::ctl
