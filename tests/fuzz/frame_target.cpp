#include <algorithm>

#include "hw/board/messages.hpp"
#include "hw/firmware/haptic_frame.h"
#include "tests/fuzz/targets.hpp"
#include "tests/hw/board/frames.hpp"

namespace haptic::test {
namespace {

/// An input is a row of steps, each: one byte what, one byte size, that many bytes.
enum LinkStep : std::uint8_t {
  kBytes = 0,         ///< bytes as they stand
  kFrame = 1,         ///< type, number (4), payload: a frame
  kDamagedFrame = 2,  ///< the same, damaged: the first two bytes say where and how
  kLinkSteps = 3,
};

struct Written {
  std::uint8_t type;
  std::uint32_t seq;
  FuzzBytes payload;
};

/// Flips a bit, or cuts its byte out, doubles it, or ends the frame with it.
void damage(FuzzBytes& wire, std::size_t where) {
  const auto at = wire.begin() + static_cast<std::ptrdiff_t>(where / 8 % wire.size());
  switch (where >> 14U) {
    case 0:
      *at ^= static_cast<std::uint8_t>(1U << where % 8);
      break;
    case 1:
      wire.erase(at);
      break;
    case 2:
      wire.insert(at, *at);
      break;
    default:
      wire.erase(at, wire.end());
      break;
  }
}

class Link {
 public:
  std::string run(FuzzInput input) {
    FuzzReader reader(input);
    while (!reader.empty() && finding_.empty()) {
      const auto what = static_cast<LinkStep>(reader.byte() % kLinkSteps);
      FuzzReader step(reader.take(reader.byte()));
      if (what == kBytes) {
        written_.clear();  // they may be any frame
        while (!step.empty() && finding_.empty()) push(step.byte());
        push(0);
      } else {
        frame(step, what == kDamagedFrame);
      }
    }
    return finding_;
  }

 private:
  void frame(FuzzReader& step, bool damaged) {
    const std::size_t where = damaged ? step.number(2) : 0;
    Written frame{step.byte(), static_cast<std::uint32_t>(step.number(4)), {}};
    while (!step.empty()) frame.payload.push_back(step.byte());
    FuzzBytes bytes = wire_of(frame.type, frame.seq, frame.payload);
    const bool must_be_read = !damaged && !bytes.empty();
    if (damaged && !bytes.empty()) damage(bytes, where);
    // A frame without its last zero ends with the first one of the next.
    if (written_.size() > 1) written_.erase(written_.begin());
    written_.push_back(std::move(frame));
    read_ = false;
    for (const std::uint8_t byte : bytes) push(byte);
    if (must_be_read && !read_) finding_ = "an undamaged frame was not read";
  }

  void push(std::uint8_t byte) {
    if (hf_push(&decoder_, byte) != HF_FRAME) return;
    const std::span<const std::uint8_t> payload = payload_of(decoder_);
    bool known = written_.empty();
    for (const Written& each : written_) {
      read_ = each.type == decoder_.type && each.seq == decoder_.seq &&
              std::ranges::equal(each.payload, payload);
      known = known || read_;
    }
    if (!known) finding_ = "a frame was read that was not written";
    read_messages(payload);
  }

  /// Every reader on every payload: it may refuse, nothing else.
  static void read_messages(std::span<const std::uint8_t> payload) {
    static_cast<void>(hw::board::read<hw::board::Hello>(payload));
    static_cast<void>(hw::board::read<hw::board::Arm>(payload));
    static_cast<void>(hw::board::read<hw::board::Command>(payload));
    static_cast<void>(hw::board::read<hw::board::Identity>(payload));
    static_cast<void>(hw::board::read<hw::board::Dof>(payload));
    static_cast<void>(hw::board::read<hw::board::State>(payload));
    static_cast<void>(hw::board::read<hw::board::Counters>(payload));
  }

  hf_decoder decoder_{};
  std::vector<Written> written_{};  ///< the last two frames; none after bytes as they stand
  bool read_{false};                ///< the last of them
  std::string finding_{};
};

/// A frame of each type, with a payload of each length that a message may have, raw bytes, and each
/// kind of damage.
std::vector<FuzzBytes> frame_seeds() {
  std::vector<FuzzBytes> seeds;
  for (const std::uint8_t type : FuzzBytes{0x01, 0x02, 0x03, 0x04, 0x81, 0x82, 0x83, 0x84}) {
    FuzzBytes seed;
    for (const std::uint8_t size : FuzzBytes{0, 8, 16, 24, 40, 64, 120, 240}) {
      seed.insert(seed.end(), {kFrame, static_cast<std::uint8_t>(size + 5), type, 0, 0, 0, size});
      seed.insert(seed.end(), size, size);
    }
    seed.insert(seed.end(), {kBytes, 4, 0, 3, type, 0});
    for (const std::uint8_t how : FuzzBytes{0x00, 0x40, 0x80, 0xC0}) {
      seed.insert(seed.end(), {kDamagedFrame, 9, how, type, type, 0, 0, 0, 1, how, 2});
    }
    seeds.push_back(std::move(seed));
  }
  return seeds;
}

}  // namespace

const FuzzTarget& frame_target() {
  static const FuzzTarget kTarget{"frame", [](FuzzInput input) { return Link().run(input); },
                                  frame_seeds, 4096};
  return kTarget;
}

}  // namespace haptic::test
