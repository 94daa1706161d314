#include "hw/board/messages.hpp"

#include <algorithm>
#include <cmath>

#include "hw/board/byte_order.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kHelloSize = 5, kArmSize = 4, kCommandHeader = 6, kIdentitySize = 60,
                      kDofSize = 36, kStateHeader = 22, kCountersSize = 32;

template <typename Fill>
Payload filled(const Fill& fill) noexcept {
  Payload payload;
  ByteWriter writer(payload.bytes);
  fill(writer);
  payload.length = writer.written().size();
  return payload;
}

void put(ByteWriter& writer, const Values& values, std::size_t count) noexcept {
  for (std::size_t i = 0; i < std::min(count, values.size()); ++i) writer.f32(values[i]);
}

/// False where a value is not finite.
bool take(ByteReader& reader, Values& values, std::size_t count) noexcept {
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = reader.f32();
    finite = finite && std::isfinite(values[i]);
  }
  return finite;
}

}  // namespace

Payload write(const Hello& message) noexcept {
  return filled([&](ByteWriter& w) {
    w.u8(message.version);
    w.u32(message.session);
  });
}

Payload write(const Arm& message) noexcept {
  return filled([&](ByteWriter& w) { w.u32(message.nonce); });
}

Payload write(const Disarm&) noexcept {
  return filled([](ByteWriter&) {});
}

Payload write(const Command& message) noexcept {
  return filled([&](ByteWriter& w) {
    w.u32(message.nonce);
    w.u8(static_cast<std::uint8_t>(message.kind));
    w.u8(message.n_a);
    put(w, message.value, message.n_a);
  });
}

Payload write(const Identity& message) noexcept {
  return filled([&](ByteWriter& w) {
    w.u8(message.version);
    w.u8(message.n_q);
    w.u8(message.n_a);
    w.u8(message.capabilities);
    w.u32(message.session);
    w.u32(message.watchdog_us);
    w.u32(message.sample_period_us);
    w.bytes(message.firmware);
    w.u8(0);
    w.text(message.serial, kSerialWidth);
    w.text(message.model, kModelWidth);
  });
}

Payload write(const Dof& message) noexcept {
  return filled([&](ByteWriter& w) {
    w.u8(message.index);
    w.u8(message.radian ? 1 : 0);
    w.u8(message.actuated ? 1 : 0);
    w.u8(0);
    w.f32(message.lower);
    w.f32(message.upper);
    w.f32(message.max_effort);
    w.f32(message.max_rate);
    w.text(message.name, kNameWidth);
  });
}

Payload write(const State& message) noexcept {
  return filled([&](ByteWriter& w) {
    w.u64(message.time_us);
    w.u32(message.nonce);
    w.u32(message.command_seq);
    w.u16(message.command_age_us);
    w.u8(static_cast<std::uint8_t>(message.state));
    w.u8(message.faults);
    w.u8(message.n_q);
    w.u8(message.measures_force ? message.n_a : std::uint8_t{0});
    put(w, message.q, message.n_q);
    if (message.measures_force) put(w, message.force, message.n_a);
  });
}

Payload write(const Counters& message) noexcept {
  return filled([&](ByteWriter& w) {
    for (const std::uint32_t count :
         {message.accepted, message.bad_crc, message.malformed, message.not_newer,
          message.wrong_nonce, message.watchdog_stops, message.states_dropped, message.sessions}) {
      w.u32(count);
    }
  });
}

template <>
std::optional<Hello> read<Hello>(Bytes payload) {
  if (payload.size() != kHelloSize) return {};
  ByteReader reader(payload);
  Hello message;
  message.version = reader.u8();
  message.session = reader.u32();
  if (message.session == 0) return {};
  return message;
}

template <>
std::optional<Arm> read<Arm>(Bytes payload) {
  if (payload.size() != kArmSize) return {};
  const Arm message{ByteReader(payload).u32()};
  if (message.nonce == 0) return {};
  return message;
}

template <>
std::optional<Disarm> read<Disarm>(Bytes payload) {
  if (!payload.empty()) return {};
  return Disarm{};
}

template <>
std::optional<Command> read<Command>(Bytes payload) {
  if (payload.size() < kCommandHeader) return {};
  ByteReader reader(payload);
  Command message;
  message.nonce = reader.u32();
  const std::uint8_t kind = reader.u8();
  message.n_a = reader.u8();
  if (kind > static_cast<std::uint8_t>(CommandKind::kPosition)) return {};
  message.kind = static_cast<CommandKind>(kind);
  if (message.n_a > kMaxDofs || payload.size() != kCommandHeader + 4U * message.n_a) return {};
  if (!take(reader, message.value, message.n_a)) return {};
  return message;
}

template <>
std::optional<Identity> read<Identity>(Bytes payload) {
  if (payload.size() != kIdentitySize) return {};
  ByteReader reader(payload);
  Identity message;
  message.version = reader.u8();
  message.n_q = reader.u8();
  message.n_a = reader.u8();
  message.capabilities = reader.u8();
  message.session = reader.u32();
  message.watchdog_us = reader.u32();
  message.sample_period_us = reader.u32();
  for (std::uint8_t& part : message.firmware) part = reader.u8();
  static_cast<void>(reader.u8());
  message.serial = reader.text(kSerialWidth);
  message.model = reader.text(kModelWidth);
  if (message.n_q == 0 || message.n_q > kMaxDofs || message.n_a > message.n_q) return {};
  if (message.watchdog_us == 0 || message.sample_period_us == 0) return {};
  return message;
}

template <>
std::optional<Dof> read<Dof>(Bytes payload) {
  if (payload.size() != kDofSize) return {};
  ByteReader reader(payload);
  Dof message;
  message.index = reader.u8();
  const std::uint8_t unit = reader.u8();
  const std::uint8_t actuated = reader.u8();
  static_cast<void>(reader.u8());
  Values v{};
  if (unit > 1 || actuated > 1 || message.index >= kMaxDofs || !take(reader, v, 4)) return {};
  message.radian = unit == 1;
  message.actuated = actuated == 1;
  message.lower = v[0];
  message.upper = v[1];
  message.max_effort = v[2];
  message.max_rate = v[3];
  message.name = reader.text(kNameWidth);
  if (!(message.lower < message.upper) || message.name.empty()) return {};
  if (message.actuated && !(message.max_effort > 0.0F && message.max_rate > 0.0F)) return {};
  return message;
}

template <>
std::optional<State> read<State>(Bytes payload) {
  if (payload.size() < kStateHeader) return {};
  ByteReader reader(payload);
  State message;
  message.time_us = reader.u64();
  message.nonce = reader.u32();
  message.command_seq = reader.u32();
  message.command_age_us = reader.u16();
  const std::uint8_t state = reader.u8();
  message.faults = reader.u8();
  message.n_q = reader.u8();
  message.n_a = reader.u8();
  message.measures_force = message.n_a > 0;
  if (state > static_cast<std::uint8_t>(BoardState::kFault)) return {};
  message.state = static_cast<BoardState>(state);
  if (message.n_q > kMaxDofs || message.n_a > kMaxDofs ||
      payload.size() != kStateHeader + 4U * (message.n_q + message.n_a)) {
    return {};
  }
  static_cast<void>(take(reader, message.q, message.n_q));
  if (!take(reader, message.force, message.n_a)) return {};
  return message;
}

template <>
std::optional<Counters> read<Counters>(Bytes payload) {
  if (payload.size() != kCountersSize) return {};
  ByteReader reader(payload);
  Counters message;
  for (std::uint32_t* count : {&message.accepted, &message.bad_crc, &message.malformed,
                               &message.not_newer, &message.wrong_nonce, &message.watchdog_stops,
                               &message.states_dropped, &message.sessions}) {
    *count = reader.u32();
  }
  return message;
}

}  // namespace haptic::hw::board
