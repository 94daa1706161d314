#include <algorithm>
#include <array>

#include "hw/board/frame_codec.hpp"
#include "hw/board/messages.hpp"
#include "hw/firmware/haptic_frame.h"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace {

using hw::board::FrameDecoder;

/// An input is a row of steps, each: one byte what, one byte size, that many bytes.
enum LinkStep : std::uint8_t {
  kBytes = 0,         ///< bytes as they stand
  kFrame = 1,         ///< type, number (4), payload: a frame, written by both encoders
  kDamagedFrame = 2,  ///< the same, and one bit is flipped: the first two bytes say which
  kLinkSteps = 3,
};

class Link {
 public:
  std::string run(FuzzInput input) {
    FuzzReader reader(input);
    while (!reader.empty() && finding_.empty()) {
      const auto what = static_cast<LinkStep>(reader.byte() % kLinkSteps);
      FuzzReader step(reader.take(reader.byte()));
      if (what == kBytes) {
        while (!step.empty() && finding_.empty()) push(step.byte());
      } else {
        frame(step, what == kDamagedFrame);
      }
    }
    return finding_;
  }

 private:
  void frame(FuzzReader& step, bool damaged) {
    const std::size_t bit = damaged ? step.number(2) : 0;
    const std::uint8_t type = step.byte();
    const auto seq = static_cast<std::uint32_t>(step.number(4));
    FuzzBytes payload;
    while (!step.empty()) payload.push_back(step.byte());
    hw::board::WireBuffer wire;
    std::array<std::uint8_t, HF_MAX_WIRE> c_wire{};
    const std::size_t size =
        hw::board::encode({static_cast<hw::board::FrameType>(type), seq, payload}, wire);
    const std::size_t c_size = hf_encode(type, seq, payload.data(), payload.size(), c_wire.data());
    if (size != c_size || !std::equal(wire.begin(), wire.begin() + size, c_wire.begin())) {
      finding_ = "the encoders differ";
    }
    if (damaged && size > 0) {
      wire[bit / 8 % size] ^= static_cast<std::uint8_t>(1U << bit % 8);
    }
    frames_ = 0;
    for (std::size_t i = 0; i < size && finding_.empty(); ++i) push(wire[i]);
    if (!damaged && size > 0 && finding_.empty() && frames_ == 0) {
      finding_ = "an undamaged frame was not read";
    }
  }

  void push(std::uint8_t byte) {
    const auto event = decoder_.push(byte);
    if (static_cast<int>(event) != static_cast<int>(hf_push(&c_decoder_, byte))) {
      finding_ = "the decoders differ";
    }
    if (event != FrameDecoder::Event::kFrame) return;
    ++frames_;
    const hw::board::Frame& frame = decoder_.frame();
    if (static_cast<std::uint8_t>(frame.type) != c_decoder_.type || frame.seq != c_decoder_.seq ||
        !std::equal(frame.payload.begin(), frame.payload.end(), c_decoder_.payload,
                    c_decoder_.payload + c_decoder_.payload_length)) {
      finding_ = "the decoders read different frames";
    }
    read_messages(frame.payload);
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

  FrameDecoder decoder_{};
  hf_decoder c_decoder_{};
  std::size_t frames_{0};
  std::string finding_{};
};

/// A frame of each type, with a payload of each length that a message may have, and raw bytes.
std::vector<FuzzBytes> frame_seeds() {
  std::vector<FuzzBytes> seeds;
  for (const std::uint8_t type : FuzzBytes{0x01, 0x02, 0x03, 0x04, 0x81, 0x82, 0x83, 0x84}) {
    FuzzBytes seed;
    for (const std::uint8_t size : FuzzBytes{0, 8, 16, 24, 40, 64, 120, 240}) {
      seed.insert(seed.end(), {kFrame, static_cast<std::uint8_t>(size + 5), type, 0, 0, 0, size});
      seed.insert(seed.end(), size, size);
    }
    seed.insert(seed.end(), {kBytes, 4, 0, 3, type, 0});
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
