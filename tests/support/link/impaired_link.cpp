#include "tests/support/link/impaired_link.hpp"

#include <algorithm>

namespace haptic::test {
namespace {

/// Draws of different purposes come from different seeds.
constexpr std::uint64_t kBurstSalt = 0xB0057;

LinkTime scaled(LinkTime time, double factor) {
  return LinkTime(std::llround(static_cast<double>(time.count()) * factor));
}

}  // namespace

BurstSchedule::BurstSchedule(const BurstRule& rule, std::uint64_t seed)
    : rule_(rule), random_(seed) {}

bool BurstSchedule::blocked(LinkTime at) {
  while (starts_.empty() || starts_.back() <= at) {
    const LinkTime since = starts_.empty() ? LinkTime(0) : starts_.back() + rule_.length;
    starts_.push_back(since + scaled(rule_.every, random_.exponential()));
  }
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), at);
  return after != starts_.begin() && at < *std::prev(after) + rule_.length;
}

ImpairedLink::ImpairedLink(const WayRules& rules, std::uint64_t seed, Carrier carrier)
    : rules_(rules), seed_(seed), carrier_(carrier) {
  for (std::size_t i = 0; i < rules_.bursts.size(); ++i) {
    bursts_.emplace_back(rules_.bursts[i], Random(seed ^ kBurstSalt, i).next());
  }
}

bool ImpairedLink::blocked(LinkTime now) {
  bool blocked = false;
  for (const Window& window : rules_.partitions) blocked |= window.holds(now, carrier_);
  for (BurstSchedule& burst : bursts_) blocked |= burst.blocked(now);
  return blocked;
}

LinkTime ImpairedLink::travel(LinkTime departure, Random& luck) const {
  LinkTime arrival = departure + rules_.delay;
  arrival += scaled(rules_.jitter_sigma, std::abs(luck.normal()));
  if (luck.uniform() < rules_.reorder) arrival += rules_.reorder_by;
  return arrival;
}

LinkTime ImpairedLink::stalled(LinkTime arrival) const {
  for (const Window& window : rules_.stalls) {
    if (window.holds(arrival, carrier_)) arrival = window.to;
  }
  return arrival;
}

std::optional<LinkTime> ImpairedLink::fate(LinkTime now, std::size_t size) {
  Random luck(seed_, ++tries_);
  const bool lost = luck.uniform() < rules_.loss;
  const bool twice = luck.uniform() < rules_.duplicate;
  second_copy_.reset();
  if (blocked(now) || lost) return std::nullopt;
  LinkTime departure = now;
  if (rules_.bytes_per_second > 0.0) {
    const LinkTime begins = std::max(now, sender_free_);
    const double queued =
        std::chrono::duration<double>(begins - now).count() * rules_.bytes_per_second;
    if (queued + static_cast<double>(size) > rules_.queue_bytes) return std::nullopt;
    departure = begins + scaled(std::chrono::seconds(1),
                                static_cast<double>(size) / rules_.bytes_per_second);
    sender_free_ = departure;
  }
  LinkTime arrival = travel(departure, luck);
  if (twice) second_copy_ = stalled(travel(departure, luck));
  if (rules_.keep_order) {
    arrival = std::max(arrival, last_arrival_);
    if (second_copy_) second_copy_ = std::max(*second_copy_, arrival);
    last_arrival_ = second_copy_.value_or(arrival);
  }
  return stalled(arrival);
}

void ImpairedLink::deliver(LinkTime arrival, Packet packet) {
  under_way_.emplace(arrival, std::move(packet));  // equal times keep their order
}

void ImpairedLink::send(Packet packet, LinkTime now) {
  const auto arrival = fate(now, packet.size());
  if (!arrival) return;
  if (second_copy_) deliver(*second_copy_, packet);
  deliver(*arrival, std::move(packet));
}

std::optional<std::pair<LinkTime, Packet>> ImpairedLink::receive(LinkTime now) {
  if (under_way_.empty() || under_way_.begin()->first > now) return std::nullopt;
  auto first = under_way_.extract(under_way_.begin());
  return std::pair(first.key(), std::move(first.mapped()));
}

LinkTime ImpairedLink::next_arrival() const noexcept {
  return under_way_.empty() ? LinkTime::max() : under_way_.begin()->first;
}

ReliableLink::ReliableLink(const WayRules& rules, std::uint64_t seed)
    : link_(rules, seed, Carrier::kTcp) {}

void ReliableLink::send(Packet packet, LinkTime now) {
  LinkTime at = now;
  LinkTime timeout = std::max(kFirstTimeout, 2 * link_.rules_.delay);
  std::optional<LinkTime> arrival = link_.fate(at, packet.size());
  while (!arrival) {
    at += timeout;
    timeout = std::min(2 * timeout, kLongestTimeout);
    arrival = link_.fate(at, packet.size());
  }
  last_arrival_ = std::max(last_arrival_, *arrival);
  link_.deliver(last_arrival_, std::move(packet));
}

std::optional<std::pair<LinkTime, Packet>> ReliableLink::receive(LinkTime now) {
  return link_.receive(now);
}

LinkTime client_clock(const ClockRules& rules, LinkTime truth) noexcept {
  LinkTime reading = truth + scaled(truth, rules.drift);
  for (const ClockStep& step : rules.steps) {
    if (truth >= step.at) reading += step.by;
  }
  return reading;
}

}  // namespace haptic::test
