#include "tests/support/loop/remote_client.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic::test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kEarly = 1e-9;  // s: rounding of t_s must not make a sample a tick late

/// A stamp of the sample's arrival, for the stream's health and its age.
void stamp(core::TimePoint now, core::ProxySnapshot& proxy) {
  proxy.tenure = 1;
  proxy.born = now;
  if (proxy.gapless_samples++ == 0) proxy.gapless_since = now;
}

/// derive_planes() of the client library for a finger as one block.
core::PlaneSet derived(const Frame& frame) {
  core::PlaneSet planes;
  const core::VecX away = frame.x_probe - frame.x;
  const double distance = away.norm();
  const int count = distance > 1e-9 ? 1 : 0;
  planes.normals.resize(away.size(), count);
  planes.offsets.resize(count);
  if (count == 0) return planes;
  planes.normals.col(0) = away / distance;
  planes.offsets[0] = planes.normals.col(0).dot(frame.x);
  return planes;
}

}  // namespace

RemoteClient::RemoteClient(ClientSettings settings, bool filtered)
    : settings_(std::move(settings)),
      looks_first_(settings_.delay_s < kTick_s && !filtered),
      random_(settings_.seed) {}

void RemoteClient::put_proxy(Frame& frame) {
  if (settings_.simulate) return settings_.simulate(frame);
  frame.walls = settings_.object ? settings_.object(frame.x_probe) : settings_.walls;
  if (frame.walls.size() == 0) {
    const core::VecX beyond = (frame.x_probe - settings_.stop).cwiseMax(0.0);
    frame.x = frame.x_probe.cwiseMin(settings_.stop);
    if (settings_.compliance > 0.0) frame.x += beyond / (1.0 + 1.0 / settings_.compliance);
    return;
  }
  if (!projection_) {
    space_ = std::make_shared<const core::ConfigurationSpace>(
        std::vector<core::Coordinate>(static_cast<std::size_t>(frame.x_probe.size())));
    projection_.emplace(*space_);
  }
  projection_->set(frame.walls, frame.x_probe);
  frame.x.resize(frame.x_probe.size());
  static_cast<void>(projection_->project(frame.x_probe, frame.x));
}

void RemoteClient::look(double t_s, const core::VecQ& q, const core::VecX& x_probe) {
  const double period = 1.0 / settings_.rate_hz;
  next_look_s_ += (1.0 + settings_.jitter * (2.0 * random_.uniform() - 1.0)) * period;
  Frame frame;
  frame.seen_s = t_s;
  frame.tick = tick_;
  frame.seq = ++seq_;
  frame.q = q;
  frame.x_probe = x_probe;
  const double delay = settings_.delay_s + settings_.delay_growth * t_s;
  frame.computed_s = t_s + 0.5 * delay;
  put_proxy(frame);
  frame.contact = frame.x != x_probe;
  const bool lost = random_.uniform() < settings_.lost;
  const double late = settings_.disorder ? 2.0 * random_.uniform() * period : 0.0;
  if (lost) return;
  frame.arrives_s = t_s + delay + late;
  on_the_way_.push_back(frame);
  if (!settings_.disorder) return;
  frame.arrives_s += late;
  on_the_way_.push_back(frame);
}

void RemoteClient::write_planes(const Frame& frame, core::PlaneSet& planes) const {
  if (frame.walls.size() > 0) {
    planes = settings_.only_in_contact && !settings_.simulate ? derived(frame) : frame.walls;
    return;
  }
  const Eigen::Index n_x = settings_.stop.size();
  planes.normals.setZero(n_x, 0);
  planes.offsets.resize(0);
  for (Eigen::Index i = 0; i < n_x; ++i) {
    if (!std::isfinite(settings_.stop[i])) continue;
    if (settings_.only_in_contact && !(frame.x_probe[i] > settings_.stop[i])) continue;
    const int k = planes.size();
    planes.normals.conservativeResize(n_x, k + 1);
    planes.normals.col(k) = core::VecX::Unit(n_x, i);
    planes.offsets.conservativeResize(k + 1);
    planes.offsets[k] =
        settings_.told_rigid ? std::max(settings_.stop[i], frame.x[i]) : settings_.stop[i];
  }
  const double told =
      settings_.told_compliance > 0.0 ? settings_.told_compliance : settings_.compliance;
  planes.compliance.setConstant(tells_compliance() ? planes.size() : 0, told);
  planes.uncertainty.setConstant(settings_.uncertainty ? planes.size() : 0,
                                 settings_.uncertainty.value_or(0.0));
}

void RemoteClient::deliver(const Frame& frame, core::TimePoint now,
                           core::ProxySnapshot& proxy) const {
  proxy.mode = settings_.mode;
  proxy.x = frame.x;
  proxy.seq = frame.seq;
  if (settings_.mode == core::ProxyMode::kPlanes) write_planes(frame, proxy.planes);
  const bool contacts = tells_compliance() || frame.anchored;
  proxy.anchored_at = contacts && settings_.anchored ? frame.tick : 0;
  proxy.seen_at = frame.tick;
  proxy.computed = core::TimePoint(
      std::chrono::duration_cast<core::Duration>(std::chrono::duration<double>(frame.computed_s)));
  stamp(now, proxy);
}

bool RemoteClient::is_time_to_look(double t_s) const noexcept {
  return t_s + kEarly >= next_look_s_;
}

void RemoteClient::look_after(double t_s, const core::VecQ& q, const core::VecX& x_probe) {
  if (!looks_first_ && is_time_to_look(t_s)) look(t_s, q, x_probe);
}

void RemoteClient::step(double t_s, core::TimePoint now, const core::VecQ& q,
                        const core::VecX& x_probe, core::ProxySnapshot& proxy) {
  ++tick_;
  if (looks_first_ && is_time_to_look(t_s)) look(t_s, q, x_probe);
  const auto arrived = [&](const Frame& frame) { return frame.arrives_s <= t_s + kEarly; };
  for (const Frame& frame : on_the_way_) {
    if (!arrived(frame) || frame.seq <= newest_.seq) continue;
    previous_ = newest_.seq == 0 ? frame : newest_;
    newest_ = frame;
    if (!settings_.between) deliver(frame, now, proxy);
  }
  std::erase_if(on_the_way_, arrived);
  if (!settings_.between || newest_.seq == 0) return;
  proxy.mode = core::ProxyMode::kHeld;
  proxy.x = settings_.between({newest_, previous_, t_s - newest_.arrives_s, q, x_probe});
  ++proxy.seq;
  stamp(now, proxy);
}

}  // namespace haptic::test
