#pragma once
/// One direction of trouble in real time: the links of tests/support/link, driven by the steady
/// clock. The scenario begins with the first packet that reaches the relay.

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {

/// The scenario's time. Read on the relay's thread only.
class RelayClock {
 public:
  using Steady = std::chrono::steady_clock;
  [[nodiscard]] LinkTime now() {
    const Steady::time_point reading = Steady::now();
    if (!start_) start_ = reading;
    return reading - *start_;
  }
  [[nodiscard]] Steady::time_point real(LinkTime time) const {
    return start_.value_or(Steady::now()) + std::chrono::duration_cast<Steady::duration>(time);
  }

 private:
  std::optional<Steady::time_point> start_{};
};

/// `Link`: ImpairedLink for datagrams, ReliableLink for a stream of bytes. Lives on the thread of
/// its context.
template <typename Link>
class TimedLink {
 public:
  TimedLink(asio::io_context& context, RelayClock& clock, Link link,
            std::function<void(Packet)> deliver)
      : clock_(clock), link_(std::move(link)), deliver_(std::move(deliver)), timer_(context) {}

  void send(Packet packet) {
    link_.send(std::move(packet), clock_.now());
    pump();
  }
  /// Stops delivering.
  void close() {
    deliver_ = nullptr;
    timer_.cancel();
  }

 private:
  void pump() {
    while (deliver_) {
      auto arrived = link_.receive(clock_.now());
      if (!arrived) break;
      deliver_(std::move(arrived->second));
    }
    if (!deliver_ || link_.next_arrival() == LinkTime::max()) return;
    timer_.expires_at(clock_.real(link_.next_arrival()));
    timer_.async_wait([this, here = std::weak_ptr(here_)](asio::error_code error) {
      if (!error && !here.expired()) pump();
    });
  }

  RelayClock& clock_;
  Link link_;
  std::function<void(Packet)> deliver_;
  asio::steady_timer timer_;
  /// A timer's handler may already be waiting for its turn when this is destroyed.
  std::shared_ptr<int> here_{std::make_shared<int>()};
};

}  // namespace haptic::test
