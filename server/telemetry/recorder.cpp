#include "server/telemetry/recorder.hpp"

#include <spdlog/spdlog.h>

#include <charconv>
#include <string_view>
#include <utility>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

const char* unit(core::Unit unit) {
  return unit == core::Unit::kMetre ? "m" : "rad";
}
const char* force_unit(core::Unit unit) {
  return unit == core::Unit::kMetre ? "n" : "n_m";
}

std::string_view text(core::ProxyMode mode) {
  switch (mode) {
    case core::ProxyMode::kNone:
      return "NONE";
    case core::ProxyMode::kHeld:
      return "HELD";
    case core::ProxyMode::kFree:
      return "FREE";
    case core::ProxyMode::kPlanes:
      return "PLANES";
  }
  return "?";
}

/// One row, field by field, at the end of a buffer.
class Row {
 public:
  explicit Row(std::string& buffer) : buffer_(buffer) {}

  void add(std::string_view value) {
    separate();
    buffer_ += value;
  }
  template <typename Number>
  void number(Number value) {
    separate();
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    buffer_.append(digits, end);
  }
  /// Exactly `size` fields: empty ones where the vector has another size.
  template <typename Vector>
  void vector(const Vector& values, int size) {
    for (int i = 0; i < size; ++i) {
      if (values.size() == size) {
        number(values[i]);
      } else {
        add("");
      }
    }
  }
  template <typename E>
  void reasons(core::BitSet32<E> set) {
    separate();
    bool first = true;
    for (std::uint8_t bit = 0; bit < 32; ++bit) {
      const auto member = static_cast<E>(bit);
      if (!set.has(member)) continue;
      if (!first) buffer_ += '|';
      buffer_ += core::reason(member);
      first = false;
    }
  }
  void end() { buffer_ += '\n'; }

 private:
  void separate() {
    if (!first_) buffer_ += ',';
    first_ = false;
  }
  std::string& buffer_;
  bool first_{true};
};

void add_certificate(Row& row, const core::Certificate& certificate) {
  row.add(certificate.status == core::CertificateStatus::kOff ? "" : name(certificate.status));
  if (certificate.status == core::CertificateStatus::kComputed) {
    row.number(certificate.margin);
    row.number(certificate.block);
  } else {
    row.add("");
    row.add("");
  }
}

/// Names of the columns of one quantity over the actuated DoFs: "tau_a_l_x_n".
void add_forces(Row& row, const core::Kinematics& kinematics, const std::string& quantity) {
  for (const core::DofSpec& dof : kinematics.dofs()) {
    if (dof.actuated) row.add(quantity + "_" + dof.name + "_" + force_unit(dof.unit));
  }
}

void add_coordinates(Row& row, const core::Kinematics& kinematics, const std::string& quantity) {
  for (const core::Coordinate& c : kinematics.space().coordinates()) {
    row.add(quantity + "_" + c.name + "_" + unit(c.unit));
  }
}

}  // namespace

std::string Recorder::header(const core::Kinematics& kinematics, bool compare, bool tracked) {
  std::string line;
  Row row(line);
  for (const char* name :
       {"time_s", "tick", "state", "staleness", "proxy_age_us", "mode", "gain", "damping_gain"}) {
    row.add(name);
  }
  for (const core::DofSpec& dof : kinematics.dofs()) row.add(dof.name);
  for (const core::DofSpec& dof : kinematics.dofs()) {
    if (dof.actuated) row.add("q_dot_" + dof.name + "_" + unit(dof.unit) + "_per_s");
  }
  add_coordinates(row, kinematics, "x_probe");
  add_coordinates(row, kinematics, "x");
  for (const core::DofSpec& dof : kinematics.dofs()) {
    row.add("q_star_" + dof.name + "_" + unit(dof.unit));
  }
  for (const char* quantity : {"tau_elastic", "tau_damping", "tau_a"}) {
    add_forces(row, kinematics, quantity);
  }
  for (const char* name :
       {"projection", "faults", "limiters", "storage_j", "tank_j", "tank_scale", "observed_j",
        "certificate", "certificate_margin", "certificate_block", "lateness_us", "skipped"}) {
    row.add(name);
  }
  if (tracked) {
    for (const char* name : {"tracker_seq", "tracker_age_us", "tracker_staleness"}) row.add(name);
  }
  if (compare) {
    for (const core::RendererKind kind : RendererComparison::kKinds) {
      add_forces(row, kinematics, "tau_" + std::string(core::name(kind)));
    }
  }
  return line;
}

Recorder::Recorder(const std::filesystem::path& file,
                   std::shared_ptr<const core::Kinematics> kinematics,
                   std::unique_ptr<RendererComparison> comparison, bool tracked)
    : path_(file),
      kinematics_(std::move(kinematics)),
      comparison_(std::move(comparison)),
      tracked_(tracked),
      file_(file) {
  static_cast<void>(file_.append(header(*kinematics_, comparison_ != nullptr, tracked_) + '\n'));
}

Recorder::~Recorder() {
  if (lost_ > 0 && !file_.ended()) {
    spdlog::warn("recording to {} lacks {} rows: the disk was too slow", path_.string(), lost_);
  }
}

void Recorder::on_record(const core::TickRecord& record) {
  if (!start_) start_ = record.input.now;
  compose(record);
  if (file_.append(row_)) {
    ++rows_;
  } else if (++lost_ == 1 && !file_.ended()) {
    spdlog::warn("recording to {} loses rows: the disk is too slow", path_.string());
  }
}

void Recorder::compose(const core::TickRecord& record) {
  const int n_q = kinematics_->layout().n_q();
  const int n_a = kinematics_->layout().n_a();
  const int n_x = kinematics_->space().n_x();
  row_.clear();
  Row row(row_);
  row.number(core::seconds(record.input.now - *start_));
  row.number(record.tick);
  row.add(core::name(record.state));
  row.add(core::name(record.staleness));
  row.number(microseconds(record.proxy_age));
  row.add(text(record.proxy_mode));
  row.number(record.gain);
  row.number(record.damping_gain);
  row.vector(record.q, n_q);
  row.vector(record.q_a_dot, n_a);
  row.vector(record.x_probe, n_x);
  row.vector(record.x, n_x);
  row.vector(record.q_star, n_q);
  row.vector(record.tau_elastic, n_a);
  row.vector(record.tau_damping, n_a);
  row.vector(record.tau_a, n_a);
  row.add(core::name(record.projection));
  row.reasons(record.faults);
  row.reasons(record.limiters);
  const core::PassivityRecord& passivity = record.passivity;
  for (const double value :
       {passivity.storage, passivity.tank, passivity.scale, passivity.observed}) {
    if (passivity.on) {
      row.number(value);
    } else {
      row.add("");
    }
  }
  add_certificate(row, record.certificate);
  row.number(microseconds(record.input.loop.lateness));
  row.number(record.input.loop.skipped);
  if (tracked_) {
    const core::TrackerRecord& tracker = record.tracker;
    row.number(tracker.seq);
    row.number(tracker.seq == 0 ? 0.0 : microseconds(tracker.age));
    row.add(core::name(tracker.level));
  }
  if (comparison_) {
    for (const core::VecA& tau : comparison_->evaluate(record)) row.vector(tau, n_a);
  }
  row.end();
}

}  // namespace haptic::server
