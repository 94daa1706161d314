// A hand of five fingers as one board: ten DoFs in its dictionary, five forces and ten readings in
// every STATE. The firmware's own code, joined to the host's side without a port.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "hw/board/board_host.hpp"
#include "hw/firmware/haptic_board.h"
#include "tests/core/model/sample_hands.hpp"

namespace haptic::hw::board {
namespace {

constexpr float kMaxEffort = 40.0F;

/// The dictionary of a board that carries `dofs`.
std::vector<hb_dof> dictionary(const std::vector<core::DofSpec>& dofs) {
  std::vector<hb_dof> entries;
  for (const core::DofSpec& dof : dofs) {
    hb_dof entry{};
    entry.name = dof.name.c_str();
    entry.radian = dof.unit == core::Unit::kRadian;
    entry.actuated = dof.actuated;
    entry.lower = static_cast<float>(dof.lower);
    entry.upper = static_cast<float>(dof.upper);
    entry.max_effort = dof.actuated ? kMaxEffort : 0.0F;
    entry.max_rate = dof.actuated ? 0.03F : 0.0F;
    entries.push_back(entry);
  }
  return entries;
}

bool append(void* to, const std::uint8_t* bytes, std::size_t length) {
  auto& sent = *static_cast<std::vector<std::uint8_t>*>(to);
  sent.insert(sent.end(), bytes, bytes + length);
  return true;
}

TEST(WholeHand, AHandFitsOneBoard) {
  const auto hand = core::make_hand_exoskeleton(core::five_fingers());
  ASSERT_EQ(hand->layout().n_q(), 10);
  ASSERT_EQ(hand->layout().n_a(), 5);
  const std::vector<hb_dof> dofs = dictionary(hand->dofs());
  const hb_config config{"HAND-1", "five fingers", {1, 0, 0},   HB_FORCE_LOOP | HB_MEASURES_FORCE,
                         25000,    1000,           dofs.data(), 10};
  hb_board board{};
  std::vector<std::uint8_t> sent;
  hb_init(&board, &config, &append, &sent);
  BoardHost host({hand->dofs(), core::VecA::Constant(5, 40.0), std::chrono::milliseconds(20), {}},
                 7);

  std::array<float, 10> q{};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = 0.001F * static_cast<float>(i + 1);
  const std::array<float, 5> force{0.5F, -1.0F, 1.5F, -2.0F, 2.5F};
  Wanted wanted{
      .arm = true, .arming = 1, .tau_a = (core::VecA(5) << 1.0, 2.0, -3.0, 4.0, 50.0).finished()};
  std::array<float, 5> reference{};
  hb_kind kind = HB_POSITION;
  bool drives = false;
  host.connect(core::TimePoint{});
  for (std::uint64_t ms = 1; ms <= 50; ++ms) {
    const core::TimePoint now{std::chrono::milliseconds(ms)};
    for (const std::uint8_t byte : host.output()) hb_receive(&board, byte, 1000 * ms);
    host.consume(host.output().size());
    hb_sample(&board, 1000 * ms, q.data(), force.data(), 0);
    drives = hb_reference(&board, 1000 * ms, reference.data(), &kind);
    host.receive(sent, now);
    sent.clear();
    host.want(wanted, now);
    host.poll(now);
  }

  ASSERT_EQ(host.stage(), BoardHost::Stage::kOpen) << host.refusal();
  ASSERT_EQ(host.reading().q.size(), 10);
  ASSERT_EQ(host.reading().force.size(), 5);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(host.reading().q[i], static_cast<double>(q[static_cast<std::size_t>(i)]));
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(host.reading().force[i], static_cast<double>(force[static_cast<std::size_t>(i)]));
  }
  EXPECT_EQ(host.reading().armed, 1U);
  EXPECT_TRUE(drives);
  EXPECT_EQ(kind, HB_FORCE);
  EXPECT_EQ(reference, (std::array<float, 5>{1.0F, 2.0F, -3.0F, 4.0F, kMaxEffort}))
      << "the last one is held at the dictionary's limit";
  EXPECT_EQ(host.counters().lost + host.counters().malformed + host.counters().bad_crc, 0U);
}

}  // namespace
}  // namespace haptic::hw::board
