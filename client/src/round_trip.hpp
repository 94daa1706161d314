#pragma once
/// How long it takes from publish() to the arrival of the first state that used the sample: the
/// network both ways, by whatever carrier, the wait for a tick and for a state.

#include <array>
#include <chrono>
#include <cstdint>

namespace haptic::client {

class RoundTrip {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  void published(std::uint64_t seq, TimePoint now) noexcept {
    sent_[seq % sent_.size()] = {seq, now};
  }
  /// A state that came `now` uses sample `seq`; 0: none.
  void used(std::uint64_t seq, TimePoint now) noexcept {
    if (seq <= newest_) return;
    newest_ = seq;
    const Sent& sent = sent_[seq % sent_.size()];
    if (sent.seq != seq) return;
    const std::chrono::nanoseconds measured = now - sent.at;
    // It rises at once and falls slowly: a horizon that is too near loses the onset of a contact.
    value_ = measured > value_ ? measured : value_ + (measured - value_) / 16;
  }
  [[nodiscard]] std::chrono::nanoseconds value() const noexcept { return value_; }

 private:
  struct Sent {
    std::uint64_t seq{0};
    TimePoint at{};
  };
  std::array<Sent, 1024> sent_{};  ///< half a second at the highest rate
  std::uint64_t newest_{0};
  std::chrono::nanoseconds value_{0};
};

}  // namespace haptic::client
