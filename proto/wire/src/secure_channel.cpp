#include "haptic/wire/secure_channel.hpp"

#include <utility>

namespace haptic::wire {
namespace {

bool is_for(End end, DatagramType type) noexcept {
  if (type == DatagramType::kProxy) return end == End::kServer;
  if (type == DatagramType::kState) return end == End::kClient;
  return true;
}

}  // namespace

SecureChannel::Keys::Keys(End end, const PathKeys& keys)
    : sealer(keys.path_id, end == End::kClient ? keys.up : keys.down),
      opener(keys.path_id, end == End::kClient ? keys.down : keys.up) {}

SecureChannel::SecureChannel(End end, const PathKeys& keys) : end_(end), current_(end, keys) {}

void SecureChannel::rekey(const PathKeys& next) {
  if (end_ == End::kServer) {
    next_.emplace(end_, next);
  } else {
    former_ = std::exchange(current_, Keys(end_, next));
    former_ends_.reset();  // runs from the first datagram under the new keys
  }
}

std::size_t SecureChannel::seal(DatagramType type, ConstBytes payload, Bytes out) noexcept {
  return current_.sealer.seal(type, payload, out);
}

Opened SecureChannel::open(ConstBytes datagram, Bytes payload, TimePoint now) noexcept {
  const HeaderReading reading = read_header(datagram);
  const auto reject = [&](Rejection why) { return Opened{why, reading.header, 0}; };
  if (reading.rejection != Rejection::kNone) return reject(reading.rejection);
  if (!is_for(end_, reading.header.type)) return reject(Rejection::kType);
  Opener* const opener = opener_of(reading.header.path_id, now);
  if (opener == nullptr) return reject(Rejection::kUnknownPath);
  const Opened opened = opener->open(reading.header, datagram, payload);
  if (opened.rejection != Rejection::kNone) return opened;
  if (next_ && opener == &next_->opener) {
    take_next(now);
  } else if (former_ && !former_ends_ && opener == &current_.opener) {
    former_ends_ = now + kOldKeysLast;
  }
  return opened;
}

Opener* SecureChannel::opener_of(std::uint32_t path_id, TimePoint now) noexcept {
  if (path_id == current_.opener.path_id()) return &current_.opener;
  if (next_ && path_id == next_->opener.path_id()) return &next_->opener;
  if (former_ && former_ends_ && now >= *former_ends_) former_.reset();
  if (former_ && path_id == former_->opener.path_id()) return &former_->opener;
  return nullptr;
}

void SecureChannel::take_next(TimePoint now) noexcept {
  former_ = std::exchange(current_, std::move(*next_));
  former_ends_ = now + kOldKeysLast;
  current_since_ = now;
  next_.reset();
}

bool SecureChannel::wants_rekey(TimePoint now) const noexcept {
  if (current_since_ && now - *current_since_ < kKeysLastAtLeast) return false;
  return !next_ &&
         (current_.sealer.wants_rekey() || current_.opener.newest() > Sealer::kPacketsPerKey / 2);
}

}  // namespace haptic::wire
