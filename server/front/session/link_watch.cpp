#include "server/front/session/link_watch.hpp"

#include <algorithm>

namespace haptic::server {
namespace {

/// A time that a tick cannot tell from nothing.
constexpr core::Duration kWorthTelling = std::chrono::milliseconds(1);

std::size_t index(Carrier carrier) noexcept {
  return carrier == Carrier::kUdp ? 1 : 0;
}

}  // namespace

const char* name(IngressVerdict verdict) noexcept {
  static constexpr std::array<const char*, kIngressVerdicts> kNames{
      "ACCEPTED",   "BACKLOG",       "OLD_SEQUENCE", "OLD_EPOCH", "WRONG_SIZE",
      "NOT_FINITE", "OUT_OF_BOUNDS", "UNKNOWN_MODE", "BAD_PLANE"};
  return kNames[static_cast<std::size_t>(verdict)];
}

CarrierFigures& LinkWatch::of(Carrier carrier) noexcept {
  return figures_[index(carrier)];
}

const CarrierFigures& LinkWatch::figures(Carrier carrier) const noexcept {
  return figures_[index(carrier)];
}

void LinkWatch::state_sent(std::uint64_t tick, core::TimePoint now, Carrier carrier) noexcept {
  sent_[tick % sent_.size()] = {tick, now};
  ++of(carrier).states;
}

void LinkWatch::judged(Carrier carrier, IngressVerdict verdict) noexcept {
  if (verdict <= IngressVerdict::kBacklog) return;
  ++of(carrier).rejected[static_cast<std::size_t>(verdict)];
}

std::optional<Departure> LinkWatch::came(
    const SampleStamp& stamp, const std::optional<wire::ClockOffset::Estimate>& other) noexcept {
  CarrierFigures& figures = of(stamp.carrier);
  Arrival& arrival = arrivals_[index(stamp.carrier)];
  ++figures.samples;
  figures.sample_bytes += stamp.bytes;
  if (arrival.last) {
    figures.longest_gap = std::max(figures.longest_gap, stamp.arrival - *arrival.last);
  }
  arrival.last = stamp.arrival;
  if (!plausible_reading(stamp.source_time_ns)) return std::nullopt;
  const core::Duration reading(stamp.source_time_ns);
  const core::Duration transit = stamp.arrival.time_since_epoch() - reading;
  if (arrival.transit) {
    const core::Duration difference = std::chrono::abs(transit - *arrival.transit);
    figures.jitter += (difference - figures.jitter) / 16;
  }
  arrival.transit = transit;
  const auto own = exchange(stamp, figures);
  if (!own) return std::nullopt;
  auto best = clock_.at(to_wire(stamp.arrival));
  if (other && (!best || other->bound < best->bound)) best = other;
  if (!best || !wire::ClockOffset::agrees(*own, *best)) return std::nullopt;
  const core::TimePoint likely(reading - best->offset), latest = likely + best->bound;
  if (stamp.arrival - latest > kWorthTelling) ++aged_;
  return Departure{std::min(likely, stamp.arrival), std::min(latest, stamp.arrival)};
}

std::optional<wire::ClockExchange> LinkWatch::exchange(const SampleStamp& stamp,
                                                       CarrierFigures& figures) noexcept {
  const Sent& sent = sent_[stamp.state_used % sent_.size()];
  if (stamp.state_used == 0 || sent.tick != stamp.state_used) return std::nullopt;
  const core::Duration round_trip = stamp.arrival - sent.at - stamp.hold;
  // Held for longer than it was away: not true.
  if (round_trip < core::Duration(0)) return std::nullopt;
  figures.round_trip.add(round_trip);
  const core::Duration source(stamp.source_time_ns);
  const wire::ClockExchange own{to_wire(sent.at), source - stamp.hold, source,
                                to_wire(stamp.arrival)};
  clock_.add(own);
  return own;
}

}  // namespace haptic::server
