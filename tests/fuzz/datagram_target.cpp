#include <algorithm>
#include <array>

#include "haptic/v1/session.pb.h"
#include "haptic/wire/path_end.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace {

/// An input is a row of steps, each: one byte what, two bytes size, that many bytes.
enum Step : std::uint8_t {
  kRaw = 0,       ///< a datagram as it stands
  kSealed = 1,    ///< first byte: type; the rest: payload, sealed with the client's keys
  kDamaged = 2,   ///< the same, and one bit is flipped: the first two bytes say which
  kRepeated = 3,  ///< the last sealed one again
  kTime = 4,      ///< the clock goes on by so many 100 us
  kSteps = 5,
};

wire::PathKeys fixed_keys() {
  wire::PathKeys keys;
  keys.path_id = 0xC0FFEE01;
  for (std::size_t i = 0; i < wire::kKeySize; ++i) {
    keys.up.key[i] = static_cast<std::uint8_t>(i);
    keys.down.key[i] = static_cast<std::uint8_t>(0x80 + i);
  }
  keys.up.salt = {1, 2, 3, 4};
  keys.down.salt = {5, 6, 7, 8};
  return keys;
}

class Siege {
 public:
  std::string run(FuzzInput input) {
    FuzzReader reader(input);
    while (!reader.empty() && finding_.empty()) {
      const auto what = static_cast<Step>(reader.byte() % kSteps);
      const std::size_t size = reader.number(2) % 1400;
      if (what == kTime) {
        now_ += std::chrono::microseconds(100 * size);
        static_cast<void>(end_.step(now_));
      } else {
        receive(datagram(what, reader.take(size)), what == kRaw || what == kDamaged);
      }
    }
    return finding_;
  }

 private:
  FuzzBytes datagram(Step what, FuzzInput bytes) {
    if (what == kRaw) return {bytes.begin(), bytes.end()};
    if (what == kRepeated) return last_;
    std::size_t bit = 0;
    if (what == kDamaged) {
      FuzzReader head(bytes);
      bit = head.number(2);
      bytes = bytes.subspan(std::min<std::size_t>(2, bytes.size()));
    }
    if (bytes.empty()) return {};
    FuzzBytes sealed(wire::kLargestDatagram);
    const auto type = static_cast<wire::DatagramType>(bytes.front() % 8);
    sealed.resize(client_.seal(
        type, bytes.subspan(1).first(std::min(bytes.size() - 1, wire::kLargestPayload)), sealed));
    last_ = sealed;
    if (what == kDamaged && !sealed.empty()) {
      sealed[bit / 8 % sealed.size()] ^= static_cast<std::uint8_t>(1U << bit % 8);
    }
    return sealed;
  }

  void receive(const FuzzBytes& bytes, bool forged) {
    answers_ = 0;
    answer_size_ = 0;
    const wire::Received received = end_.receive(bytes, peer_, now_);
    const bool rejected = received.rejection != wire::Rejection::kNone;
    // A payload may be off behind a right tag; nothing else that was forged may pass.
    if (forged && !rejected) finding_ = "a forged datagram was taken";
    if (rejected && received.message) finding_ = "a rejected datagram brought a message";
    if (rejected && answers_ > 0) finding_ = "a rejected datagram was answered";
    if (answers_ > 1) finding_ = "a datagram was answered twice";
    if (answer_size_ > bytes.size()) finding_ = "an answer is longer than the question";
    if (!received.message) return;
    if (received.message->size() > wire::kLargestPayload) finding_ = "a message is too long";
    v1::ProxySample sample;
    if (!sample.ParseFromArray(received.message->data(),
                               static_cast<int>(received.message->size()))) {
      end_.message_unreadable();
    }
  }

  wire::SecureChannel client_{wire::End::kClient, fixed_keys()};
  wire::PathEnd end_{{wire::End::kServer,
                      fixed_keys(),
                      {},
                      [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
                        ++answers_;
                        answer_size_ = std::max(answer_size_, datagram.size());
                      },
                      [next = std::uint64_t{0}]() mutable { return ++next; }}};
  wire::PeerAddress peer_{{}, 7};
  wire::TimePoint now_{std::chrono::hours(1)};
  FuzzBytes last_{};
  std::size_t answers_{0}, answer_size_{0};
  std::string finding_{};
};

void append(FuzzBytes& input, Step what, const FuzzBytes& bytes) {
  input.push_back(what);
  input.push_back(static_cast<std::uint8_t>(bytes.size() >> 8U));
  input.push_back(static_cast<std::uint8_t>(bytes.size()));
  input.insert(input.end(), bytes.begin(), bytes.end());
}

FuzzBytes typed(wire::DatagramType type, const std::string& payload) {
  FuzzBytes bytes(1 + payload.size());
  bytes.front() = static_cast<std::uint8_t>(type);
  std::copy(payload.begin(), payload.end(), bytes.begin() + 1);
  return bytes;
}

std::vector<FuzzBytes> datagram_seeds() {
  v1::ProxySample sample;
  sample.set_seq(7);
  sample.set_mode(v1::PROXY_MODE_HELD);
  sample.add_position(0.25);
  const auto proxy = typed(wire::DatagramType::kProxy, sample.SerializeAsString());
  const auto challenge = typed(wire::DatagramType::kPathChallenge, std::string(40, 'c'));
  // The server's own tokens are 1, 2, 3 ...: so a response can be right.
  std::string answer(40, '\0');
  answer[7] = 1;
  const auto response = typed(wire::DatagramType::kPathResponse, answer);
  FuzzBytes talk, trouble;
  append(talk, kSealed, challenge);
  append(talk, kTime, {});
  append(talk, kSealed, response);
  append(talk, kSealed, proxy);
  append(talk, kSealed, typed(wire::DatagramType::kClose, ""));
  append(trouble, kDamaged, proxy);
  append(trouble, kSealed, proxy);
  append(trouble, kRepeated, {});
  append(trouble, kRaw, {0x68, 0x70, 1, 1, 0xC0, 0xFF, 0xEE, 1});
  return {talk, trouble};
}

}  // namespace

const FuzzTarget& datagram_target() {
  static const FuzzTarget kTarget{"datagram", [](FuzzInput input) { return Siege().run(input); },
                                  datagram_seeds, 8192};
  return kTarget;
}

}  // namespace haptic::test
