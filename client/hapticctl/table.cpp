#include "table.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "haptic/client/state_fields.hpp"

namespace haptic::ctl {

namespace {

using client::StateField;
using Kind = StateField::Kind;

template <typename... Arguments>
std::string text(const char* format, Arguments... arguments) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, arguments...);
  return buffer;
}

/// Five digits are enough for people.
std::string shortened(const StateField& field, std::size_t i) {
  const std::string& value = field.values[i];
  if (field.kind == Kind::kBits) return value.empty() ? "none" : value;
  const bool fraction =
      value.find('.') != std::string::npos || value.find("e-") != std::string::npos;
  return field.kind == Kind::kNumber && fraction ? text("%.5g", std::strtod(value.c_str(), nullptr))
                                                 : value;
}

/// "0.0123 m"; a unit that ends the field's name is not said again.
std::string with_unit(const StateField& field, std::size_t i) {
  const std::string& unit = field.units[field.axis.empty() ? 0 : i];
  const bool said = field.name.size() > unit.size() + 1 &&
                    field.name.substr(field.name.size() - unit.size() - 1) == "_" + unit;
  return shortened(field, i) + (unit.empty() || said ? "" : " " + unit);
}

bool absent(const std::vector<StateField>& message) {
  return std::all_of(message.begin(), message.end(),
                     [](const StateField& field) { return field.values.empty(); });
}

/// Appends the items to the last row; an item that would go beyond `width` begins a further row.
void add_items(const Rows& items, std::size_t width, Rows& rows) {
  for (const std::string& item : items) {
    if (rows.back().size() + item.size() + 2 > width) rows.emplace_back("  ");
    rows.back() += "  " + item;
  }
}

/// "gain 0.5" of every value without an axis.
Rows scalars(const std::vector<StateField>& fields) {
  Rows items;
  for (const StateField& field : fields) {
    if (!field.axis.empty() || field.kind == Kind::kMessage) continue;
    items.push_back(field.name);
    for (std::size_t i = 0; i < field.values.size(); ++i) items.back() += " " + with_unit(field, i);
  }
  return items;
}

/// "slide 0.125 m" of every value along an axis.
Rows labelled(const StateField& field) {
  Rows items;
  for (std::size_t i = 0; i < std::min(field.labels.size(), field.values.size()); ++i) {
    items.push_back(field.labels[i] + " " + with_unit(field, i));
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
    words = text("K %s %.4g -> %.4g %s/%s: %s %.0f ms old", dof.name.c_str(), whole, share * whole,
                 effort_unit(dof.unit).c_str(), dof.unit.c_str(), kWords[reason],
                 static_cast<double>(s.derating_delay.count()) * 1e-3);
  }
  return words;
}

nlohmann::json to_json(const std::vector<StateField>& fields);

nlohmann::json value_of(const StateField& field, const std::string& value) {
  if (field.kind == Kind::kName) return value;
  if (field.kind == Kind::kNumber) {
    nlohmann::json number = nlohmann::json::parse(value, nullptr, false);
    return number.is_discarded() ? nlohmann::json() : number;  // JSON has no nan
  }
  nlohmann::json names = nlohmann::json::array();
  for (std::size_t from = 0, to = 0; from < value.size(); from = to + 1) {
    to = std::min(value.find('|', from), value.size());
    names.push_back(value.substr(from, to - from));
  }
  return names;
}

nlohmann::json value_of(const StateField& field) {
  if (!field.repeated && field.kind == Kind::kMessage) return to_json(field.messages.front());
  if (!field.repeated) return value_of(field, field.values.front());
  nlohmann::json list = nlohmann::json::array();
  for (const std::string& value : field.values) list.push_back(value_of(field, value));
  for (const auto& message : field.messages) list.push_back(to_json(message));
  return list;
}

/// Null for an absent message.
nlohmann::json to_json(const std::vector<StateField>& fields) {
  nlohmann::json object;
  if (absent(fields)) return object;
  for (const StateField& field : fields) object[field.name] = value_of(field);
  return object;
}

nlohmann::json schema_of(const std::vector<StateField>& fields) {
  nlohmann::json list = nlohmann::json::array();
  for (const StateField& field : fields) {
    nlohmann::json entry{{"name", field.name}};
    if (field.kind == Kind::kMessage && !field.repeated) {
      entry["fields"] = schema_of(field.messages.front());
    } else if (!field.axis.empty()) {
      entry.update({{"axis", field.axis}, {"labels", field.labels}, {"units", field.units}});
    } else if (!field.units.front().empty()) {
      entry["unit"] = field.units.front();
    }
    list.push_back(entry);
  }
  return list;
}

}  // namespace

Rows table(const client::DeviceInfo& device, const client::DeviceState& s, double seconds,
           std::uint64_t conflated, std::size_t width) {
  const std::vector<StateField> fields = client::state_fields(device, s);
  Rows rows{text("%s  t %.1f s  conflated %llu", device.name.c_str(), seconds,
                 static_cast<unsigned long long>(conflated))};
  add_items(scalars(fields), width, rows);
  if (const std::string words = derated(device, s); !words.empty()) rows.push_back("  " + words);
  for (const StateField& field : fields) {
    for (const auto& message : field.messages) {
      if (absent(message)) continue;
      rows.push_back("  " + field.name + ":");
      add_items(scalars(message), width, rows);
    }
    if (field.axis.empty() || field.values.empty()) continue;
    rows.push_back(text("  %-20s", field.name.c_str()));
    add_items(labelled(field), width, rows);
  }
  return rows;
}

std::string line(const client::DeviceInfo& device, const client::DeviceState& s, double seconds) {
  std::string all =
      text("%9.3f s  %s  %-9s %s  gain %.2f ", seconds, device.name.c_str(), client::name(s.state),
           age("proxy", s.proxy_seq_used, s.staleness, s.proxy_age).c_str(), s.gain);
  std::string forces;
  std::size_t actuated = 0;
  for (std::size_t i = 0; i < device.dofs.size(); ++i) {
    const auto& dof = device.dofs[i];
    all += text(" %s %8.5f %s", dof.name.c_str(), at(s.q, i), dof.unit.c_str());
    if (!dof.actuated) continue;
    forces += text("  tau_a %s %7.3f %s", dof.name.c_str(), at(s.tau_a, actuated),
                   effort_unit(dof.unit).c_str());
    if (actuated < s.error_bound.size()) forces += text(" +-%.3f", s.error_bound[actuated]);
    ++actuated;
  }
  all += forces;
  if (s.tracker) {
    all += "  " + age("pose", s.tracker->seq_used, s.tracker->staleness, s.tracker->age);
  }
  if (const std::string words = derated(device, s); !words.empty()) all += "  " + words;
  return all + "  faults " + joined(client::fault_names(s.faults));
}

nlohmann::json state_json(const client::DeviceInfo& device, const client::DeviceState& state) {
  nlohmann::json all = to_json(client::state_fields(device, state));
  all["device"] = device.name;
  return all;
}

nlohmann::json json_fields(const client::DeviceInfo& device) {
  return schema_of(client::state_fields(device, {}));
}

std::string loop_row(const client::ServerInfo& server) {
  return text("loop: %llu ticks, %llu skipped, late %.1f us p50, %.1f us p99; tick %.2f us p50",
              static_cast<unsigned long long>(server.ticks),
              static_cast<unsigned long long>(server.skipped_ticks), server.lateness_p50_us,
              server.lateness_p99_us, server.tick_p50_us);
}

std::size_t Screen::width() {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  // A row that wraps would be two, and the next refresh would land below the last.
  return (known ? size.ws_col : 80) - 1;
}

void Screen::show(const Rows& rows) {
  if (shown_ > 0) std::printf("\x1b[%zuA", shown_);
  for (const std::string& row : rows) std::printf("%s\x1b[K\n", row.substr(0, width()).c_str());
  // Fewer rows than before leave some of them below: they are erased.
  if (rows.size() < shown_) std::printf("\x1b[J");
  std::fflush(stdout);
  shown_ = rows.size();
}

}  // namespace haptic::ctl
