#include "tests/report/bits/touching_client.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::report {
namespace {

using core::Duration;
using core::PlaneSet;
using core::TimePoint;
using core::VecX;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr int kTouches = 8;
constexpr int kMostWalls = 4;
constexpr int kMostNamed = 4;                   // coordinates per wall
constexpr double kLost = 0.08;                  // share of the samples
constexpr Duration kFirst = milliseconds(300);  // free, so that force can be asked for

double seconds(Duration d) {
  return std::chrono::duration<double>(d).count();
}
Duration drawn(haptic::test::Random& random, Duration least, Duration most) {
  return least + Duration(static_cast<std::int64_t>(random.uniform() *
                                                    static_cast<double>((most - least).count())));
}
double between(haptic::test::Random& random, double least, double most) {
  return least + random.uniform() * (most - least);
}

/// Half of what counts as 1 in the scene's metric; without one 5 mm and 0.1 rad.
VecX lengths(const core::PipelineConfig& config) {
  const core::ConfigurationSpace& space = config.kinematics->space();
  VecX lengths(space.n_x());
  const Eigen::MatrixXd W = config.projection.metric.matrix();
  for (int i = 0; i < space.n_x(); ++i) {
    const core::Coordinate& coordinate = space.coordinates()[static_cast<std::size_t>(i)];
    lengths[i] = W.size() > 0                            ? 0.5 / std::sqrt(W(i, i))
                 : coordinate.unit == core::Unit::kMetre ? 0.005
                                                         : 0.1;
  }
  return lengths;
}

}  // namespace

TouchingClient::TouchingClient(const core::PipelineConfig& config, std::uint64_t seed)
    : config_(config), random_(seed, 1), phase_(2 * seed), length_(lengths(config)) {
  constexpr double kRates[] = {60.0, 90.0, 144.0, 30.0};
  period_ = microseconds(static_cast<std::int64_t>(1e6 / kRates[seed % 4]));
  delay_ = milliseconds(2) + milliseconds(7) * static_cast<int>(seed % 5);
}

void TouchingClient::begin_lease(std::uint32_t tenure, core::ProxySnapshot& proxy) {
  tenure_ = tenure;
  seq_ = 0;
  last_arrival_ = {};
  on_the_way_.clear();
  proxy = {};
  proxy.tenure = tenure;
}

double TouchingClient::offset(const Wall& wall, double since_s) const {
  return wall.offset + wall.swing * std::sin(wall.swing_rate * since_s);
}

TouchingClient::Wall TouchingClient::make_wall(const VecX& x_probe) {
  const int n_x = static_cast<int>(x_probe.size());
  Wall wall;
  wall.count = std::min(n_x, 1 + static_cast<int>(random_.uniform() * kMostNamed));
  wall.first = static_cast<int>(random_.uniform() * (n_x - wall.count + 1));
  wall.normal = VecX::Zero(n_x);
  for (int i = wall.first; i < wall.first + wall.count; ++i) {
    wall.normal[i] = random_.normal() / length_[i];
  }
  wall.normal *= 1.0 / wall.normal.cwiseProduct(length_).norm();
  wall.mobility = wall.normal.dot(config_.projection.metric.steepest(wall.normal));
  wall.offset = wall.normal.dot(x_probe) - between(random_, -0.3, 0.8);
  wall.swing = between(random_, 0.0, 0.4);
  wall.swing_rate = between(random_, 2.0, 12.0);
  return wall;
}

void TouchingClient::begin_phase(const VecX& x_probe, TimePoint now) {
  const bool first = phase_began_ == TimePoint{};
  phase_began_ = now;
  phase_ends_ = now + (first ? kFirst : drawn(random_, milliseconds(250), milliseconds(550)));
  touch_ = first ? Touch::kFree : static_cast<Touch>(phase_++ % kTouches);
  walls_.clear();
  const int walls = 1 + static_cast<int>(random_.uniform() * kMostWalls);
  for (int i = 0; i < walls; ++i) walls_.push_back(make_wall(x_probe));
}

void TouchingClient::step(const core::TickRecord& newest, TimePoint now,
                          core::ProxySnapshot& proxy) {
  if (now >= phase_ends_ && newest.anchor.x_probe.size() > 0) {
    begin_phase(newest.anchor.x_probe, now);
    next_look_ = std::max(next_look_, now);
  }
  if (phase_began_ != TimePoint{} && now >= next_look_) {
    look(newest, now);
    next_look_ += period_;
  }
  // In the order in which they were sent; an older one never replaces a newer one.
  std::erase_if(on_the_way_, [&](Sent& sent) {
    if (sent.arrives > now) return false;
    if (sent.sample.seq <= proxy.seq && proxy.mode != core::ProxyMode::kNone) return true;
    const bool gap =
        last_arrival_ == TimePoint{} || now - last_arrival_ > config_.scene.staleness.hold_end;
    const TimePoint since = gap ? now : proxy.gapless_since;
    const std::uint64_t samples = gap ? 1 : proxy.gapless_samples + 1;
    proxy = sent.sample;
    proxy.born = now;
    proxy.gapless_since = since;
    proxy.gapless_samples = samples;
    last_arrival_ = now;
    return true;
  });
}

/// The sample of what the simulation saw just now.
void TouchingClient::look(const core::TickRecord& newest, TimePoint now) {
  const bool lost = random_.uniform() < kLost;
  const Duration on_the_way = delay_ + drawn(random_, Duration(0), period_);
  const VecX& x_probe = newest.anchor.x_probe;
  if (lost || touch_ == Touch::kSilent) return;
  Sent sent;
  sent.arrives = now + on_the_way;
  core::ProxySnapshot& sample = sent.sample;
  sample.tenure = tenure_;
  sample.seq = ++seq_;
  sample.computed = now;
  sample.valid_for = seq_ % 7 == 0 ? Duration(milliseconds(12)) : Duration(0);
  sample.seen_at = newest.beat.tick;
  sample.x = x_probe;
  if (touch_ == Touch::kFree) {
    sample.mode = core::ProxyMode::kFree;
  } else {
    const double since_s = seconds(now - phase_began_);
    for (const Wall& wall : walls_) {
      const double depth = wall.normal.dot(sample.x) - offset(wall, since_s);
      if (depth <= 0.0) continue;
      sample.x -= depth / wall.mobility * config_.projection.metric.steepest(wall.normal);
    }
    sample.mode = planes_touch() ? core::ProxyMode::kPlanes : core::ProxyMode::kHeld;
    if (planes_touch()) sample.planes = told(sample.x, since_s);
    if (touch_ == Touch::kPushed || touch_ == Touch::kCurved) sample.anchored_at = sample.seen_at;
  }
  on_the_way_.push_back(sent);
}

PlaneSet TouchingClient::told(const VecX& x, double since_s) {
  const auto n = static_cast<Eigen::Index>(walls_.size());
  PlaneSet planes;
  planes.normals.resize(x.size(), n);
  planes.offsets.resize(n);
  const bool soft = touch_ == Touch::kSoft || touch_ == Touch::kCurved || touch_ == Touch::kPushed;
  if (soft) planes.compliance.resize(n);
  if (touch_ == Touch::kMoving) planes.velocity.resize(n);
  if (touch_ == Touch::kSoft) planes.uncertainty.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Wall& wall = walls_[k];
    planes.normals.col(i) = wall.normal;
    planes.offsets[i] = offset(wall, since_s);
    if (soft) planes.compliance[i] = 0.3 * static_cast<double>(i + 1) * wall.mobility;
    if (touch_ == Touch::kSoft) planes.uncertainty[i] = 0.2;
    if (touch_ == Touch::kMoving) {
      planes.velocity[i] = wall.swing * wall.swing_rate * std::cos(wall.swing_rate * since_s);
    }
    if (touch_ != Touch::kCurved) continue;
    planes.first[k] = static_cast<std::uint8_t>(wall.first);
    planes.curved[k] = static_cast<std::uint8_t>(wall.count);
    const Eigen::Index at = planes.curvature.size();
    planes.curvature.conservativeResize(at + PlaneSet::triangle(wall.count));
    Eigen::Index next = at;
    for (int row = 0; row < wall.count; ++row) {
      for (int column = 0; column <= row; ++column) {
        const double share = row == column ? 0.4 : 0.1;
        planes.curvature[next++] =
            share / (length_[wall.first + row] * length_[wall.first + column]);
      }
    }
  }
  if (touch_ == Touch::kPushed) tell_laws(planes);
  return planes;
}

/// Each contact pushes an object; the first two push the same one, in directions 60 degrees apart.
void TouchingClient::tell_laws(PlaneSet& planes) {
  const Eigen::Index n = planes.offsets.size();
  planes.laws.resize(Eigen::NoChange, n);
  planes.ids.resize(n);
  planes.objects.setZero(Eigen::NoChange, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double mobility = walls_[static_cast<std::size_t>(i)].mobility;
    planes.laws.col(i) << 0.002 / mobility, 0.04 / mobility, 0.2 / mobility, 0.05 / mobility;
    planes.ids[i] = static_cast<double>(i + 1);
    if (n < 2 || i > 1) continue;
    planes.objects(0, i) = 1.0;
    planes.objects(1, i) = i == 0 ? 1.0 : 0.5;
    planes.objects(2, i) = i == 0 ? 0.0 : std::sqrt(0.75);
  }
}

}  // namespace haptic::report
