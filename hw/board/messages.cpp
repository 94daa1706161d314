#include "hw/board/messages.hpp"

#include <algorithm>
#include <cmath>

#include "hw/board/byte_order.hpp"

namespace haptic::hw::board {
namespace {

// One function per message lists its fields in the order of the wire. `Io` is a ByteWriter or a
// ByteReader, so that writing and reading cannot differ.

template <typename Io>
void fields(Io& io, Hello& m) {
  io(m.version, m.session);
}

template <typename Io>
void fields(Io& io, Arm& m) {
  io(m.nonce);
}

template <typename Io>
void fields(Io&, Disarm&) {}

template <typename Io>
void fields(Io& io, Command& m) {
  io(m.nonce, m.kind, m.n_a);
  io.list(m.value, m.n_a);
}

template <typename Io>
void fields(Io& io, Identity& m) {
  std::uint8_t reserved = 0;
  io(m.version, m.n_q, m.n_a, m.capabilities, m.session, m.watchdog_us, m.sample_period_us);
  io.list(m.firmware, m.firmware.size());
  io(reserved);
  io.text(m.serial, kSerialWidth);
  io.text(m.model, kModelWidth);
}

template <typename Io>
void fields(Io& io, Dof& m) {
  std::uint8_t reserved = 0;
  io(m.index, m.radian, m.actuated, reserved, m.lower, m.upper, m.max_effort, m.max_rate);
  io.text(m.name, kNameWidth);
}

template <typename Io>
void fields(Io& io, State& m) {
  io(m.time_us, m.nonce, m.command_seq, m.command_age_us, m.state, m.faults, m.n_q, m.n_f);
  io.list(m.q, m.n_q);
  io.list(m.force, m.n_f);
}

template <typename Io>
void fields(Io& io, Counters& m) {
  io(m.accepted, m.bad_crc, m.malformed, m.not_newer, m.wrong_nonce, m.watchdog_stops,
     m.states_dropped, m.sessions);
}

bool finite(const Values& values, std::size_t count) noexcept {
  return std::all_of(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count),
                     [](float value) { return std::isfinite(value); });
}

bool valid(const Hello& m) noexcept {
  return m.session != 0;
}

bool valid(const Arm& m) noexcept {
  return m.nonce != 0;
}

bool valid(const Disarm&) noexcept {
  return true;
}

bool valid(const Command& m) noexcept {
  return m.kind <= HB_POSITION && m.n_a <= kMaxDofs && finite(m.value, m.n_a);
}

bool valid(const Identity& m) noexcept {
  return m.n_q > 0 && m.n_q <= kMaxDofs && m.n_a <= m.n_q && m.watchdog_us > 0 &&
         m.sample_period_us > 0;
}

bool valid(const Dof& m) noexcept {
  return m.index < kMaxDofs && finite({m.lower, m.upper, m.max_effort, m.max_rate}, 4) &&
         m.lower < m.upper && !m.name.empty() &&
         (!m.actuated || (m.max_effort > 0.0F && m.max_rate > 0.0F));
}

bool valid(const State& m) noexcept {
  return m.state <= HB_FAULT && m.n_q <= kMaxDofs && m.n_f <= kMaxDofs && finite(m.force, m.n_f);
}

bool valid(const Counters&) noexcept {
  return true;
}

}  // namespace

template <typename Message>
Payload write(Message message) noexcept {
  Payload payload;
  ByteWriter writer(payload.bytes);
  fields(writer, message);
  payload.length = writer.written().size();
  return payload;
}

template <typename Message>
std::optional<Message> read(std::span<const std::uint8_t> payload) {
  ByteReader reader(payload);
  std::optional<Message> message(std::in_place);
  fields(reader, *message);
  if (!reader.exact() || !valid(*message)) message.reset();
  return message;
}

template Payload write(Hello) noexcept;
template Payload write(Arm) noexcept;
template Payload write(Disarm) noexcept;
template Payload write(Command) noexcept;
template Payload write(Identity) noexcept;
template Payload write(Dof) noexcept;
template Payload write(State) noexcept;
template Payload write(Counters) noexcept;

template std::optional<Hello> read(std::span<const std::uint8_t>);
template std::optional<Arm> read(std::span<const std::uint8_t>);
template std::optional<Disarm> read(std::span<const std::uint8_t>);
template std::optional<Command> read(std::span<const std::uint8_t>);
template std::optional<Identity> read(std::span<const std::uint8_t>);
template std::optional<Dof> read(std::span<const std::uint8_t>);
template std::optional<State> read(std::span<const std::uint8_t>);
template std::optional<Counters> read(std::span<const std::uint8_t>);

}  // namespace haptic::hw::board
