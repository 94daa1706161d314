#include "haptic/wire/path_end.hpp"

#include <algorithm>
#include <utility>

namespace haptic::wire {

PathEnd::PathEnd(PathEndSetup setup)
    : end_(setup.end),
      send_(std::move(setup.send)),
      channel_(setup.end, setup.keys),
      machine_(setup.rules, std::move(setup.token)),
      counted_path_(setup.keys.path_id),
      sending_path_(setup.keys.path_id) {}

Received PathEnd::receive(ConstBytes datagram, const PeerAddress& from, TimePoint arrival) {
  const Opened opened = channel_.open(datagram, payload_, arrival);
  if (opened.rejection != Rejection::kNone) {
    statistics_.rejected(opened.rejection);
    return {opened.rejection, {}, PathChange::kNone};
  }
  count(opened.header, datagram.size(), arrival);
  if (opened.header.type == DatagramType::kClose) {
    if (!left_before(opened.header)) close_ = opened.header;
  } else if (end_ == End::kServer && !left_before(opened.header)) {
    machine_.heard(from, arrival);
  }
  const ConstBytes payload = ConstBytes(payload_).first(opened.size);
  const auto unreadable = [this] {
    message_unreadable();
    return Received{Rejection::kPayload, {}, PathChange::kNone};
  };
  switch (opened.header.type) {
    case DatagramType::kProxy:
    case DatagramType::kState:
      return {Rejection::kNone, payload, PathChange::kNone};
    case DatagramType::kPathChallenge: {
      const auto challenge = read_challenge(payload);
      if (!challenge) return unreadable();
      answer(*challenge, payload.size(), from, arrival);
      return {};
    }
    case DatagramType::kPathResponse: {
      const auto response = read_response(payload);
      if (!response) return unreadable();
      return {Rejection::kNone, {}, hear(*response, from, arrival)};
    }
    case DatagramType::kClose:
      return {Rejection::kNone, {}, machine_.closed()};
  }
  return {};
}

void PathEnd::count(const Header& header, std::size_t size, TimePoint arrival) {
  follow_keys();  // the datagram may have been the server's change-over to new keys
  if (header.path_id != counted_path_ && header.path_id == channel_.path_id()) {
    counted_path_ = header.path_id;
    statistics_.renumber();
  }
  // Late ones under former keys were counted as lost; they are no part of this numbering.
  if (header.path_id == counted_path_) {
    statistics_.accepted(header.packet_number, size, arrival);
  }
}

/// A datagram that a CLOSE overtook says nothing of where the other end is: it has left.
bool PathEnd::left_before(const Header& header) const noexcept {
  if (!close_) return false;
  if (header.path_id == close_->path_id) return header.packet_number < close_->packet_number;
  return header.path_id != channel_.path_id();  // under former keys
}

void PathEnd::answer(const PathChallenge& challenge, std::size_t size, const PeerAddress& to,
                     TimePoint arrival) {
  const std::int64_t reading = arrival.time_since_epoch().count();
  const Bytes payload = Bytes(payload_).first(size);
  write(
      PathResponse{challenge.token, reading, reading, statistics_.packets(), statistics_.newest()},
      payload);
  seal_and_send(DatagramType::kPathResponse, payload, to);
}

PathChange PathEnd::hear(const PathResponse& response, const PeerAddress& from, TimePoint arrival) {
  if (const auto sent = machine_.sent_at(response.token)) {
    clock_offset_.add({*sent, Duration(response.received_ns), Duration(response.sent_ns), arrival});
    // A peer may claim what it likes; more than we sent under these keys it cannot have had.
    const std::uint64_t newest = std::min(response.newest, channel_.sent());
    if (newest >= peer_report_.newest) {
      peer_report_ = {std::min(response.packets, newest), newest};
    }
  }
  return machine_.responded(from, response, arrival);
}

PathChange PathEnd::step(TimePoint now) {
  const PathChange change = machine_.step(now);
  while (const auto due = machine_.due(now)) {
    const Bytes payload = Bytes(payload_).first(due->size);
    write(PathChallenge{due->token}, payload);
    seal_and_send(DatagramType::kPathChallenge, payload, due->to);
  }
  return change;
}

bool PathEnd::send(ConstBytes message) {
  if (!machine_.in_use() || message.size() > kLargestPayload) return false;
  seal_and_send(end_ == End::kClient ? DatagramType::kProxy : DatagramType::kState, message,
                machine_.address());
  return true;
}

void PathEnd::close() {
  if (machine_.state() == PathState::kOff) return;
  seal_and_send(DatagramType::kClose, {}, machine_.address());
  machine_.stop();
}

void PathEnd::rekey(const PathKeys& next) {
  channel_.rekey(next);
  follow_keys();
}

/// The other end's reports count the packets under the keys that this end sends with.
void PathEnd::follow_keys() {
  if (channel_.path_id() == sending_path_) return;
  sending_path_ = channel_.path_id();
  machine_.rekeyed();
  peer_report_ = {};
}

void PathEnd::seal_and_send(DatagramType type, ConstBytes payload, const PeerAddress& to) {
  const std::size_t size = channel_.seal(type, payload, datagram_);
  if (size > 0) send_(to, ConstBytes(datagram_).first(size));
}

}  // namespace haptic::wire
