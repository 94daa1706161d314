#include "fuzz/frame_fuzz.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "hw/board/frame_codec.hpp"
#include "hw/firmware/haptic_frame.h"

namespace haptic::test {
namespace {

using hw::board::Frame;
using hw::board::FrameDecoder;
using Bytes = std::vector<std::uint8_t>;

struct Written {
  std::uint8_t type{0};
  std::uint32_t seq{0};
  Bytes payload{};
  bool damaged{false};
  bool read{false};
};

class Execution {
 public:
  Execution(std::mt19937_64& random, FuzzResult& result) : random_(random), result_(result) {}

  void run() {
    const std::size_t count = 1 + draw(4);
    for (std::size_t i = 0; i < count; ++i) add(static_cast<std::uint32_t>(i));
    decode();
    for (const Written& frame : written_) {
      if (!frame.damaged && !frame.read) fail("an undamaged frame was not read");
    }
  }

 private:
  std::size_t draw(std::size_t below) { return random_() % below; }
  void fail(const std::string& what) {
    if (result_.finding.empty()) {
      result_.finding = "execution " + std::to_string(result_.executions) + ": " + what;
    }
  }

  void add(std::uint32_t index) {
    Written frame;
    frame.type = static_cast<std::uint8_t>(random_());
    // The place in the stream is part of the number, so that a frame read is known again.
    frame.seq = (static_cast<std::uint32_t>(random_()) & ~3U) | index;
    frame.payload.resize(draw(2) == 0 ? draw(hw::board::kMaxPayload + 1) : draw(24));
    const bool many_zeros = draw(2) == 0;
    for (std::uint8_t& byte : frame.payload) {
      byte = many_zeros && draw(2) == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(random_());
    }
    Bytes wire = encoded(frame);
    frame.damaged = draw(2) == 0;
    if (frame.damaged) damage(wire);
    stream_.insert(stream_.end(), wire.begin(), wire.end());
    written_.push_back(std::move(frame));
  }

  Bytes encoded(const Written& frame) {
    hw::board::WireBuffer wire;
    const std::size_t length = hw::board::encode(
        {static_cast<hw::board::FrameType>(frame.type), frame.seq, frame.payload}, wire);
    std::array<std::uint8_t, HF_MAX_WIRE> c_wire{};
    const std::size_t c_length =
        hf_encode(frame.type, frame.seq, frame.payload.data(), frame.payload.size(), c_wire.data());
    if (!std::equal(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length),
                    c_wire.begin(), c_wire.begin() + static_cast<std::ptrdiff_t>(c_length))) {
      fail("the encoders differ");
    }
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
  }

  /// Damage stays within the frame's two zeros, which it may take as well.
  void damage(Bytes& wire) {
    const std::size_t times = 1 + draw(3);
    for (std::size_t i = 0; i < times && !wire.empty(); ++i) {
      const auto at = static_cast<std::ptrdiff_t>(draw(wire.size()));
      const auto byte = static_cast<std::uint8_t>(random_());
      switch (draw(6)) {
        case 0:
          wire[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << draw(8));
          break;
        case 1:
          wire[static_cast<std::size_t>(at)] = byte;
          break;
        case 2:
          wire.erase(wire.begin() + at);
          break;
        case 3:
          wire.insert(wire.begin() + at, byte);
          break;
        case 4:
          wire.resize(static_cast<std::size_t>(at));
          break;
        default:
          wire.insert(wire.begin() + at, 1 + draw(300), byte);
          break;
      }
    }
  }

  void decode() {
    FrameDecoder decoder;
    hf_decoder c_decoder{};
    for (const std::uint8_t byte : stream_) {
      const auto event = decoder.push(byte);
      const auto c_event = hf_push(&c_decoder, byte);
      if (static_cast<int>(event) != static_cast<int>(c_event)) fail("the decoders differ");
      if (event == FrameDecoder::Event::kBadCrc) ++result_.bad_crc;
      if (event == FrameDecoder::Event::kMalformed) ++result_.malformed;
      if (event == FrameDecoder::Event::kFrame) check(decoder.frame(), c_decoder);
    }
  }

  void check(const Frame& frame, const hf_decoder& c) {
    ++result_.frames;
    const bool same = static_cast<std::uint8_t>(frame.type) == c.type && frame.seq == c.seq &&
                      std::equal(frame.payload.begin(), frame.payload.end(), c.payload,
                                 c.payload + c.payload_length);
    if (!same) fail("the decoders read different frames");
    Written* const origin =
        (frame.seq & 3U) < written_.size() ? &written_[frame.seq & 3U] : nullptr;
    if (origin == nullptr || origin->type != static_cast<std::uint8_t>(frame.type) ||
        origin->seq != frame.seq ||
        !std::equal(frame.payload.begin(), frame.payload.end(), origin->payload.begin(),
                    origin->payload.end())) {
      fail("a frame was read that nobody wrote");
      return;
    }
    origin->read = true;
  }

  std::mt19937_64& random_;
  FuzzResult& result_;
  std::vector<Written> written_{};
  Bytes stream_{};
};

}  // namespace

FuzzResult fuzz_frames(std::uint64_t seed, std::uint64_t executions) {
  std::mt19937_64 random(seed);
  FuzzResult result;
  for (; result.executions < executions && result.finding.empty(); ++result.executions) {
    Execution(random, result).run();
  }
  return result;
}

}  // namespace haptic::test
