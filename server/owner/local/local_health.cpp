#include "server/owner/local/local_health.hpp"

#include <cmath>
#include <utility>

#include "haptic/wire/printable.hpp"

namespace haptic::server {
namespace {

constexpr core::Duration kLookEvery = std::chrono::seconds(1);

/// "\t998": how many more there are than `before`, per second.
std::string rate(std::uint64_t now, std::uint64_t before, core::Duration passed) {
  const double seconds = core::seconds(passed);
  const double more = static_cast<double>(now - before);
  return "\t" + std::to_string(seconds > 0.0 ? std::lround(more / seconds) : 0L);
}

}  // namespace

LocalHealth::LocalHealth(const Owner& owner, std::vector<std::string> addresses)
    : owner_(owner), addresses_(std::move(addresses)) {}

LocalHealth::Look LocalHealth::counted(core::TimePoint now) const {
  Look look{now, {}};
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    const IngressCounters samples = owner_.status(i).samples;
    Counts& counts = look.devices.emplace_back();
    for (std::size_t v = 0; v < kIngressVerdicts; ++v) {
      const auto verdict = static_cast<IngressVerdict>(v);
      (Verdict{verdict}.used() ? counts.accepted : counts.refused) += samples[verdict];
    }
  }
  return look;
}

void LocalHealth::look(core::TimePoint now) {
  if (!looks_[1].devices.empty() && now - looks_[1].at < kLookEvery) return;
  looks_[0] = std::exchange(looks_[1], counted(now));
}

std::string LocalHealth::text(const FrontView& front, core::TimePoint now) {
  look(now);
  std::string all = "ok\nfront\t";
  all += front.serves ? "serves\t" : "none\t";
  const double age = front.serves ? core::seconds(now - front.since) : 0.0;
  all += std::to_string(front.number) + "\t" + std::to_string(front.process) + "\t" +
         std::to_string(std::lround(age)) + "\t" + wire::printable(front.why);
  for (const std::string& address : addresses_) all += "\naddress\t" + wire::printable(address);
  const Look newest = counted(now);
  // Rates are of half a second or more: the newest look may have been a moment ago.
  const bool long_ago = now - looks_[1].at >= kLookEvery / 2;
  const Look& before = long_ago || looks_[0].devices.empty() ? looks_[1] : looks_[0];
  for (std::size_t i = 0; i < newest.devices.size(); ++i) {
    const DeviceStatus status = owner_.status(i);
    const Counts& counts = newest.devices[i];
    const Counts& then = before.devices[i];
    all += "\ndevice\t" + wire::printable(owner_.devices()[i].name) + "\t" +
           std::string(core::name(status.state)) + "\t" + std::to_string(status.sessions) + "\t" +
           std::to_string(status.observers) + "\t" + std::to_string(counts.accepted) +
           rate(counts.accepted, then.accepted, now - before.at) + "\t" +
           std::to_string(counts.refused) + rate(counts.refused, then.refused, now - before.at) +
           "\t" + wire::printable(status.controller.view());
  }
  return all;
}

}  // namespace haptic::server
