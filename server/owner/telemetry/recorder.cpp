#include "server/owner/telemetry/recorder.hpp"

#include <spdlog/spdlog.h>

#include <cctype>
#include <charconv>
#include <utility>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

/// "n_m_per_rad" of "N m/rad".
std::string in_column(const std::string& unit) {
  std::string text;
  for (const char c : unit) {
    if (c == '/') {
      text += "_per_";
    } else {
      text += c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return text;
}

/// "tau_a_l_x_n"; a unit that ends the field's name is not said again.
std::string column(const std::string& field, const std::string& label, const std::string& unit) {
  const std::string suffix = unit.empty() ? "" : "_" + in_column(unit);
  const bool said = !suffix.empty() && field.size() > suffix.size() &&
                    field.substr(field.size() - suffix.size()) == suffix;
  return field + (label.empty() ? "" : "_" + label) + (said ? "" : suffix);
}

schema::Labels labels_of(const core::Kinematics& kinematics) {
  const auto name = [](core::Unit unit) { return unit == core::Unit::kMetre ? "m" : "rad"; };
  schema::Labels labels;
  for (const core::DofSpec& dof : kinematics.dofs()) {
    labels.add_dof({dof.name, name(dof.unit)}, dof.actuated);
  }
  for (const core::Coordinate& c : kinematics.space().coordinates()) {
    labels.coordinates.push_back({c.name, name(c.unit)});
  }
  return labels;
}

/// One row, cell by cell, at the end of a buffer.
class Row {
 public:
  explicit Row(std::string& buffer) : buffer_(buffer) {}

  /// The buffer, for the next cell's text.
  std::string& next() {
    if (!first_) buffer_ += ',';
    first_ = false;
    return buffer_;
  }
  template <typename Number>
  void number(Number value) {
    char digits[32];
    next().append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
  template <typename Vector>
  void vector(const Vector& values) {
    for (const double value : values) number(value);
  }
  /// One cell per label, all empty if the field is absent; without labels one cell for all.
  void field(const google::protobuf::Message& message, const schema::Leaf& leaf,
             std::size_t labels) {
    const google::protobuf::Message* const holder = schema::holder(message, leaf);
    const int count = schema::count(message, leaf);
    if (labels == 0) next();
    for (int i = 0; labels == 0 && i < count; ++i) {
      if (i > 0) buffer_ += ' ';
      schema::append_value(*holder, *leaf.field, i, buffer_);
    }
    for (std::size_t i = 0; i < labels; ++i) {
      next();
      if (static_cast<std::size_t>(count) != labels) continue;
      schema::append_value(*holder, *leaf.field, static_cast<int>(i), buffer_);
    }
  }

 private:
  std::string& buffer_;
  bool first_{true};
};

}  // namespace

std::string Recorder::header(const core::Kinematics& kinematics, bool compare) {
  const schema::Labels labels = labels_of(kinematics);
  std::string line;
  Row row(line);
  row.next() += "time_s";
  for (const schema::Leaf& leaf : schema::leaves(*v1::DeviceState::descriptor())) {
    if (leaf.axis == v1::AXIS_UNSPECIFIED) {
      row.next() += column(leaf.name, "", schema::unit_of(*leaf.field));
    }
    for (const schema::Label& label : labels.of(leaf.axis)) {
      row.next() += leaf.name == "q"
                        ? label.name
                        : column(leaf.name, label.name, schema::unit_of(*leaf.field, label));
    }
  }
  const auto add_forces = [&](const std::string& quantity) {
    for (const schema::Label& label : labels.actuated) {
      row.next() += column(quantity, label.name, schema::effort_unit(label.unit));
    }
  };
  row.next() += "damping_gain";
  add_forces("tau_damping");
  row.next() += "lateness_us";
  row.next() += "skipped";
  if (!compare) return line;
  for (const core::RendererKind kind : core::kPaperRenderers) {
    add_forces("tau_" + std::string(core::name(kind)));
  }
  return line;
}

Recorder::Recorder(const NewFile& file, const core::Kinematics& kinematics,
                   const v1::DeviceState& state, std::unique_ptr<RendererComparison> comparison,
                   bool realtime)
    : labels_(labels_of(kinematics)),
      leaves_(schema::leaves(*v1::DeviceState::descriptor())),
      comparison_(std::move(comparison)),
      state_(state),
      file_(file, realtime) {
  static_cast<void>(file_.append(header(kinematics, comparison_ != nullptr) + '\n'));
}

Recorder::~Recorder() {
  if (lost_ > 0 && !file_.ended()) {
    spdlog::warn("recording to {} lacks {} rows: the disk was too slow", file_.path().string(),
                 lost_);
  }
}

void Recorder::on_record(const core::TickRecord& record) {
  if (!start_) start_ = record.input.now;
  compose(record);
  if (file_.append(row_)) {
    ++rows_;
  } else if (++lost_ == 1 && !file_.ended()) {
    spdlog::warn("recording to {} loses rows: the disk is too slow", file_.path().string());
  }
}

void Recorder::compose(const core::TickRecord& record) {
  row_.clear();
  Row row(row_);
  row.number(core::seconds(record.input.now - *start_));
  for (const schema::Leaf& leaf : leaves_) row.field(state_, leaf, labels_.of(leaf.axis).size());
  row.number(record.life.damping_gain);
  const core::VecA& damping = record.effort.tau_damping;
  row.vector(damping);
  for (std::size_t i = static_cast<std::size_t>(damping.size()); i < labels_.actuated.size(); ++i) {
    row.next();
  }
  row.number(microseconds(record.input.loop.lateness));
  row.number(record.input.loop.skipped);
  if (comparison_) {
    for (const core::VecA& tau : comparison_->evaluate(record)) row.vector(tau);
  }
  row_ += '\n';
}

}  // namespace haptic::server
