#pragma once
/// One direction of a link in trouble, on virtual time: packets go in at a time and come out at
/// another, or not at all, or twice. No sockets, no sleeping, no clock: the same seed and the same
/// packets give the same arrivals.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/link/random.hpp"
#include "tests/support/link/scenario.hpp"

namespace haptic::test {

/// Times of bursts; they do not depend on the packets.
class BurstSchedule {
 public:
  BurstSchedule(const BurstRule& rule, std::uint64_t seed);
  /// Any order of times.
  [[nodiscard]] bool blocked(LinkTime at);

 private:
  BurstRule rule_;
  Random random_;
  std::vector<LinkTime> starts_{};
};

using Packet = std::vector<std::uint8_t>;

class ImpairedLink {
 public:
  /// `seed` of the scenario; `carrier` decides which of its windows hold.
  ImpairedLink(const WayRules& rules, std::uint64_t seed, Carrier carrier);

  /// `now` never falls.
  void send(Packet packet, LinkTime now);
  /// The next packet that has arrived at `now`, and when; call until there is none.
  [[nodiscard]] std::optional<std::pair<LinkTime, Packet>> receive(LinkTime now);
  /// Arrival of the next packet; LinkTime::max() if none is under way.
  [[nodiscard]] LinkTime next_arrival() const noexcept;

 private:
  friend class ReliableLink;
  /// When a packet that leaves at `now` arrives; none if it is lost. Each call draws new luck.
  [[nodiscard]] std::optional<LinkTime> fate(LinkTime now, std::size_t size);
  [[nodiscard]] LinkTime travel(LinkTime departure, Random& luck) const;
  [[nodiscard]] LinkTime stalled(LinkTime arrival) const;
  [[nodiscard]] bool blocked(LinkTime now);
  void deliver(LinkTime arrival, Packet packet);

  const WayRules rules_;
  const std::uint64_t seed_;
  const Carrier carrier_;
  std::vector<BurstSchedule> bursts_{};
  std::uint64_t tries_{0};
  LinkTime sender_free_{0};
  LinkTime last_arrival_{0};
  std::optional<LinkTime> second_copy_{};
  std::multimap<LinkTime, Packet> under_way_{};
};

/// The same trouble under a transport that keeps order and loses nothing, like TCP: a lost packet
/// is sent again after a timeout that doubles, and later packets wait for it. A model, for the ages
/// after a fallback on virtual time; the relay uses real TCP.
class ReliableLink {
 public:
  /// Linux's least retransmission timeout, and the longest that matters here.
  static constexpr LinkTime kFirstTimeout{std::chrono::milliseconds(200)};
  static constexpr LinkTime kLongestTimeout{std::chrono::seconds(4)};

  ReliableLink(const WayRules& rules, std::uint64_t seed);

  void send(Packet packet, LinkTime now);
  [[nodiscard]] std::optional<std::pair<LinkTime, Packet>> receive(LinkTime now);
  [[nodiscard]] LinkTime next_arrival() const noexcept { return link_.next_arrival(); }

 private:
  ImpairedLink link_;
  LinkTime last_arrival_{0};
};

/// The client's steady clock as the scenario has it.
[[nodiscard]] LinkTime client_clock(const ClockRules& rules, LinkTime truth) noexcept;

}  // namespace haptic::test
