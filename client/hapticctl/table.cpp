#include "table.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
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

/// A force as a bar about the middle: "[     ###|        ]".
std::string bar(double value, double limit) {
  constexpr int kHalf = 12;
  const int filled =
      limit > 0.0 && std::isfinite(value)
          ? std::clamp(static_cast<int>(std::lround(value / limit * kHalf)), -kHalf, kHalf)
          : 0;
  std::string drawn(2 * kHalf + 1, ' ');
  drawn[kHalf] = '|';
  for (int i = 1; i <= std::abs(filled); ++i) {
    drawn[static_cast<std::size_t>(filled < 0 ? kHalf - i : kHalf + i)] = '#';
  }
  return "[" + drawn + "]";
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

/// "gain 0.5" of every value without an axis, in rows of at most `width`.
void add_scalars(const std::vector<StateField>& fields, std::string row, std::size_t width,
                 Rows& rows) {
  for (const StateField& field : fields) {
    if (!field.axis.empty() || field.kind == Kind::kMessage) continue;
    std::string item = "  " + field.name;
    for (std::size_t i = 0; i < field.values.size(); ++i) item += " " + with_unit(field, i);
    if (row.size() + item.size() > width) {
      rows.push_back(row);
      row = "  ";
    }
    row += item;
  }
  rows.push_back(row);
}

/// A column of the table with one cell per label, some empty.
using Column = std::vector<std::string>;

/// The fields along `labels`, as columns beside the names of the rows.
void add_block(const std::vector<std::string>& labels, const std::vector<Column>& columns,
               std::size_t width, Rows& rows) {
  Rows block;
  for (const Column& column : columns) {
    std::size_t widest = 0;
    for (const std::string& cell : column) widest = std::max(widest, cell.size());
    if (block.empty() || block[0].size() + widest + 2 > width) {
      rows.insert(rows.end(), block.begin(), block.end());
      block.assign(1, text("  %-12s", ""));
      for (const std::string& label : labels) block.push_back(text("  %-12s", label.c_str()));
    }
    for (std::size_t i = 0; i < column.size(); ++i) {
      block[i] += std::string(widest + 2 - column[i].size(), ' ') + column[i];
    }
  }
  rows.insert(rows.end(), block.begin(), block.end());
}

/// Fields that are absent have no column.
Column column_of(const StateField& field, const std::vector<std::string>& labels) {
  Column column{field.name};
  for (const std::string& label : labels) {
    const auto found = std::find(field.labels.begin(), field.labels.end(), label);
    const auto i = static_cast<std::size_t>(found - field.labels.begin());
    const bool given = i < std::min(field.labels.size(), field.values.size());
    column.push_back(given ? with_unit(field, i) : "");
  }
  return column;
}

double at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : std::nan("");
}

/// Age and its meaning; without a proxy there is none.
std::string age(const client::DeviceState& s) {
  if (s.proxy_seq_used == 0) return "no proxy";
  return text("%s, age %.1f ms", client::name(s.staleness),
              static_cast<double>(s.proxy_age.count()) * 1e-3);
}

/// Which client says where the palm is, and how old that is.
std::string tracker(const client::DeviceInfo& device, const client::TrackerState& pose) {
  const std::string who = device.tracker.empty() ? "nobody" : device.tracker;
  if (pose.seq_used == 0) return "tracker " + who + ", no pose";
  return text("tracker %s, pose %llu %s, age %.1f ms", who.c_str(),
              static_cast<unsigned long long>(pose.seq_used), client::name(pose.staleness),
              static_cast<double>(pose.age.count()) * 1e-3);
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
  Rows rows;
  add_scalars(fields,
              text("%s  t %.1f s  conflated %llu", device.name.c_str(), seconds,
                   static_cast<unsigned long long>(conflated)),
              width, rows);
  for (const StateField& field : fields) {
    for (const auto& message : field.messages) {
      if (!absent(message)) add_scalars(message, "  " + field.name + ":", width, rows);
    }
  }
  if (s.tracker) rows.push_back("  " + tracker(device, *s.tracker));

  std::vector<std::string> dofs, coordinates;
  std::vector<Column> of_dofs, of_coordinates;
  Column bars{"tau_a / force_limit"};
  std::size_t actuated = 0;
  for (const auto& dof : device.dofs) {
    dofs.push_back(dof.name);
    bars.emplace_back();
    if (!dof.actuated) continue;
    bars.back() = bar(at(s.tau_a, actuated), at(device.force_limit, actuated));
    ++actuated;
  }
  for (const auto& coordinate : device.coordinates) coordinates.push_back(coordinate.name);
  for (const StateField& field : fields) {
    if (field.axis.empty() || field.values.empty()) continue;
    if (field.axis == "coordinate") {
      of_coordinates.push_back(column_of(field, coordinates));
    } else {
      of_dofs.push_back(column_of(field, dofs));
    }
  }
  of_dofs.push_back(bars);
  add_block(dofs, of_dofs, width, rows);
  add_block(coordinates, of_coordinates, width, rows);
  return rows;
}

std::string line(const client::DeviceInfo& device, const client::DeviceState& s, double seconds) {
  std::string all = text("%9.3f s  %s  %-9s %s  gain %.2f ", seconds, device.name.c_str(),
                         client::name(s.state), age(s).c_str(), s.gain);
  std::string forces;
  std::size_t actuated = 0;
  for (std::size_t i = 0; i < device.dofs.size(); ++i) {
    const auto& dof = device.dofs[i];
    all += text(" %s %8.5f %s", dof.name.c_str(), at(s.q, i), dof.unit.c_str());
    if (!dof.actuated) continue;
    forces += text("  tau_a %s %7.3f %s", dof.name.c_str(), at(s.tau_a, actuated++),
                   effort_unit(dof.unit).c_str());
  }
  all += forces;
  if (s.tracker) all += "  " + tracker(device, *s.tracker);
  return all + "  faults " + joined(client::fault_names(s.faults));
}

std::string json_line(const client::DeviceInfo& device, const client::DeviceState& s,
                      std::uint64_t conflated) {
  nlohmann::json all = to_json(client::state_fields(device, s));
  all["device"] = device.name;
  all["conflated"] = conflated;
  if (s.tracker) all["tracker"]["holder"] = device.tracker;
  return all.dump();
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
