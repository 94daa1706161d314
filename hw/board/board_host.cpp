#include "hw/board/board_host.hpp"

#include <algorithm>
#include <utility>

namespace haptic::hw::board {

BoardHost::BoardHost(Expectation expected, std::uint64_t seed)
    : expected_(std::move(expected)), random_(seed) {}

std::uint32_t BoardHost::new_number(std::uint32_t unlike) {
  std::uint32_t number = 0;
  while (number == 0 || number == unlike) number = static_cast<std::uint32_t>(random_());
  return number;
}

template <typename Message>
void BoardHost::send(hf_type type, const Message& message) {
  const Payload payload = write(message);
  std::array<std::uint8_t, HF_MAX_WIRE> wire;
  const std::size_t length = hf_encode(static_cast<std::uint8_t>(type), ++tx_seq_,
                                       payload.bytes.data(), payload.length, wire.data());
  if (length > output_.size() - output_length_) {
    ++counters_.commands_held_back;
    return;
  }
  std::copy_n(wire.begin(), length, output_.begin() + static_cast<std::ptrdiff_t>(output_length_));
  output_length_ += length;
  ++counters_.sent;
}

void BoardHost::consume(std::size_t count) noexcept {
  count = std::min(count, output_length_);
  std::copy(output_.begin() + static_cast<std::ptrdiff_t>(count),
            output_.begin() + static_cast<std::ptrdiff_t>(output_length_), output_.begin());
  output_length_ -= count;
}

// ---- handshake ------------------------------------------------------------------------------------

void BoardHost::connect(core::TimePoint now) {
  disconnect();
  session_ = new_number(session_);
  stage_ = Stage::kGreeting;
  greet(now);
}

void BoardHost::disconnect() {
  stage_ = Stage::kClosed;
  hf_reset(&decoder_);
  output_length_ = 0;
  reading_.open = reading_.broken = reading_.force_over_limit = false;
  reading_.armed = 0;
  nonce_ = board_nonce_ = 0;  // the next arming needs a new request
  board_state_ = HB_DISARMED;
}

void BoardHost::greet(core::TimePoint now) {
  identified_ = false;
  dofs_.fill(std::nullopt);
  greeted_ = now;
  send(HF_HELLO, Hello{HB_PROTOCOL_VERSION, session_});
}

void BoardHost::on_identity() {
  const auto identity = read<Identity>(payload());
  if (!identity) {
    ++counters_.malformed;
    return;
  }
  if (stage_ != Stage::kGreeting || identity->session != session_) return;
  filter_.restart(decoder_.seq);
  identity_ = *identity;
  identified_ = true;
  refuse_if(difference(expected_, identity_, known_));
}

void BoardHost::refuse_if(std::string difference) {
  refusal_ = std::move(difference);
  if (!refusal_.empty()) stage_ = Stage::kRefused;
}

void BoardHost::on_dof(const Dof& dof) {
  if (stage_ != Stage::kGreeting || !identified_) return;
  dofs_[dof.index] = dof;
  const auto known = std::count_if(dofs_.begin(), dofs_.begin() + identity_.n_q,
                                   [](const auto& entry) { return entry.has_value(); });
  if (known < identity_.n_q) return;
  for (std::size_t i = 0; i < identity_.n_q; ++i) {
    refuse_if(difference(expected_, i, *dofs_[i]));
    if (stage_ == Stage::kRefused) return;
  }
  refuse_if(difference_of_actuators(expected_, identity_));
  if (stage_ == Stage::kRefused) return;
  stage_ = Stage::kOpen;
  clock_.restart();
}

/// A DC motor gives most power at half its stall force and half its no-load rate, which is where
/// drives are rated: its force falls by 2 max_effort over max_rate.
Introduction BoardHost::introduction() const {
  Introduction said{.identity = identity_, .drive_damping = core::VecA(identity_.n_a)};
  Eigen::Index a = 0;
  for (std::size_t i = 0; i < identity_.n_q; ++i) {
    if (!dofs_[i] || !dofs_[i]->actuated || a == identity_.n_a) continue;
    said.drive_damping[a++] = 2.0 * static_cast<double>(dofs_[i]->max_effort / dofs_[i]->max_rate);
  }
  said.drive_damping.conservativeResize(a);
  return said;
}

// ---- frames ---------------------------------------------------------------------------------------

void BoardHost::receive(std::span<const std::uint8_t> bytes, core::TimePoint now) {
  for (const std::uint8_t byte : bytes) {
    switch (hf_push(&decoder_, byte)) {
      case HF_FRAME:
        ++counters_.frames;
        on_frame(now);
        break;
      case HF_MALFORMED:
        ++counters_.malformed;
        break;
      case HF_BAD_CRC:
        ++counters_.bad_crc;
        break;
      case HF_NONE:
        break;
    }
  }
}

void BoardHost::on_frame(core::TimePoint now) {
  if (stage_ == Stage::kClosed) return;
  if (decoder_.type == HF_IDENTITY && stage_ == Stage::kGreeting) {
    on_identity();
    return;
  }
  if (!identified_) return;  // a frame of an earlier session
  if (!filter_.accept(decoder_.seq)) {
    ++counters_.not_newer;
    return;
  }
  counters_.lost = filter_.lost();
  heard_ = now;
  if (decoder_.type == HF_DOF) {
    if (const auto dof = read<Dof>(payload())) return on_dof(*dof);
  } else if (decoder_.type == HF_STATE) {
    if (const auto state = read<State>(payload())) return on_state(*state, now);
  } else if (decoder_.type == HF_COUNTERS) {
    if (const auto counters = read<Counters>(payload())) {
      counters_.board = *counters;
      return;
    }
  } else if (decoder_.type == HF_IDENTITY) {
    return;  // the answer to a HELLO sent twice
  }
  ++counters_.malformed;
}

void BoardHost::on_state(const State& state, core::TimePoint now) {
  if (stage_ != Stage::kOpen) return;
  if (state.n_q != identity_.n_q || (state.n_f != 0 && state.n_f != identity_.n_a)) {
    ++counters_.malformed;
    return;
  }
  board_state_ = state.state;
  board_nonce_ = state.nonce;
  reading_.open = true;
  ++reading_.seq;
  reading_.time = clock_.map(state.time_us, now);
  reading_.q.resize(state.n_q);
  for (int i = 0; i < state.n_q; ++i) reading_.q[i] = static_cast<double>(state.q[i]);
  reading_.force.resize(state.n_f);
  for (int i = 0; i < state.n_f; ++i) reading_.force[i] = static_cast<double>(state.force[i]);
  follow_arming(state);
}

void BoardHost::follow_arming(const State& state) noexcept {
  const bool ours = nonce_ != 0 && state.nonce == nonce_;
  const bool latched = state.state == HB_STOPPED || state.state == HB_FAULT;
  reading_.armed = ours && state.state == HB_ARMED ? arming_ : 0;
  // A latched stop counts while it belongs to the present arming; later it only waits for the next
  // one. A fault that is present now always counts.
  reading_.broken = (latched && ours) || state.faults != 0;
  reading_.force_over_limit =
      (state.faults & HB_FORCE_OVER_LIMIT) != 0 || (latched && ours && reading_.force_over_limit);
}

// ---- arming and commands --------------------------------------------------------------------------

void BoardHost::want(const Wanted& wanted, core::TimePoint now) {
  const bool had = wanted_.arm;
  wanted_ = wanted;
  if (stage_ != Stage::kOpen) return;
  if (!wanted.arm) {
    if (!had && nonce_ == 0) return;
    nonce_ = 0;
    reading_.armed = 0;
    asked_ = now;
    send(HF_DISARM, Disarm{});
    return;
  }
  if (wanted.arming != arming_) {
    arming_ = wanted.arming;
    nonce_ = new_number(nonce_ != 0 ? nonce_ : board_nonce_);
    asked_ = now;
    send(HF_ARM, Arm{nonce_});
  }
  if (nonce_ == 0) return;  // the link was lost: this arming is over
  Command command;
  command.nonce = nonce_;
  command.n_a = identity_.n_a;
  const bool by_position = wanted.position.size() > 0;
  if (by_position) command.kind = HB_POSITION;
  const core::VecA& value = by_position ? wanted.position : wanted.tau_a;
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(value.size(), identity_.n_a); ++i) {
    command.value[static_cast<std::size_t>(i)] = static_cast<float>(value[i]);
  }
  send(HF_COMMAND, command);
}

void BoardHost::poll(core::TimePoint now) {
  if (stage_ == Stage::kGreeting && now - greeted_ >= kRepeat) greet(now);
  if (stage_ != Stage::kOpen) return;
  if (now - heard_ > kSilence) {
    connect(now);
    return;
  }
  if (now - asked_ < kAgain) return;
  asked_ = now;
  const bool latched = board_state_ == HB_STOPPED || board_state_ == HB_FAULT;
  if (nonce_ != 0 && board_nonce_ != nonce_ && !(latched && reading_.broken)) {
    send(HF_ARM, Arm{nonce_});
  } else if (nonce_ == 0 && board_state_ == HB_ARMED) {
    send(HF_DISARM, Disarm{});
  }
}

}  // namespace haptic::hw::board
