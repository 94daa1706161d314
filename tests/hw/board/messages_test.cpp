/// The payloads against the document's vectors, which were made by another program.
#include "hw/board/messages.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "vectors.hpp"

namespace haptic::hw::board {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t kSession = 0x11223344, kNonce = 0xA1B2C3D4;

template <typename Message>
Bytes bytes_of(const Message& message) {
  const Payload payload = write(message);
  const auto view = payload.view();
  return {view.begin(), view.end()};
}

Command command() {
  Command c{kNonce, HB_FORCE, 1, {}};
  c.value[0] = 2.5F;
  return c;
}

Identity identity() {
  return {.n_q = 2,
          .n_a = 1,
          .capabilities = HB_FORCE_LOOP | HB_MEASURES_FORCE,
          .session = kSession,
          .watchdog_us = 25000,
          .sample_period_us = 1000,
          .firmware = {1, 2, 3},
          .serial = "HX-0001",
          .model = "finger exoskeleton"};
}

State state() {
  State s{.time_us = 123456789,
          .nonce = kNonce,
          .command_seq = 3,
          .command_age_us = 850,
          .state = HB_ARMED,
          .n_q = 2,
          .n_f = 1};
  s.q[0] = 0.015625F;
  s.q[1] = -0.25F;
  s.force[0] = 1.5F;
  return s;
}

TEST(BoardMessages, WriteTheDocumentsVectors) {
  EXPECT_EQ(bytes_of(Hello{1, kSession}), test::vector("HELLO").payload);
  EXPECT_EQ(bytes_of(Arm{kNonce}), test::vector("ARM").payload);
  EXPECT_EQ(bytes_of(Disarm{}), test::vector("DISARM").payload);
  EXPECT_EQ(bytes_of(command()), test::vector("COMMAND").payload);
  EXPECT_EQ(bytes_of(identity()), test::vector("IDENTITY").payload);
  EXPECT_EQ(bytes_of(Dof{0, false, true, 0.0F, 0.05F, 40.0F, 0.03125F, "l_x"}),
            test::vector("DOF").payload);
  EXPECT_EQ(bytes_of(state()), test::vector("STATE").payload);
  EXPECT_EQ(bytes_of(Counters{1000, 1, 2, 3, 4, 5, 6, 1}), test::vector("COUNTERS").payload);
}

/// Calls `visit` with an empty message of each kind and the vector of its name.
template <typename Visit>
void for_each_message(Visit visit) {
  visit(Hello{}, test::vector("HELLO"));
  visit(Arm{}, test::vector("ARM"));
  visit(Disarm{}, test::vector("DISARM"));
  visit(Command{}, test::vector("COMMAND"));
  visit(Identity{}, test::vector("IDENTITY"));
  visit(Dof{}, test::vector("DOF"));
  visit(Dof{}, test::vectors()[6]);  // rad, sensed
  visit(State{}, test::vector("STATE"));
  visit(Counters{}, test::vector("COUNTERS"));
}

TEST(BoardMessages, ReadTheDocumentsVectors) {
  for_each_message([](auto message, const test::Vector& vector) {
    const auto back = read<decltype(message)>(vector.payload);
    ASSERT_TRUE(back) << vector.name;
    EXPECT_EQ(bytes_of(*back), vector.payload) << vector.name;
  });
}

TEST(BoardMessages, OtherLengthsAreRefused) {
  for_each_message([](auto message, const test::Vector& vector) {
    Bytes longer = vector.payload;
    longer.push_back(0);
    EXPECT_FALSE(read<decltype(message)>(longer)) << vector.name;
    if (vector.payload.empty()) return;
    longer.resize(longer.size() - 2);
    EXPECT_FALSE(read<decltype(message)>(longer)) << vector.name;
  });
}

/// True if `message` can be read back after `change`.
template <typename Message, typename Change>
bool readable(Message message, Change change) {
  change(message);
  return read<Message>(bytes_of(message)).has_value();
}

TEST(BoardMessages, ANonFiniteCommandIsRefused) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(readable(command(), [](Command& c) { c.value[0] = kNan; }));
  EXPECT_FALSE(readable(command(), [](Command& c) { c.value[0] = kInfinity; }));
}

TEST(BoardMessages, RefusesOnlyANonFiniteForce) {
  EXPECT_FALSE(readable(state(), [](State& s) { s.force[0] = kNan; }));
  EXPECT_TRUE(readable(state(), [](State& s) { s.q[0] = kNan; }));
}

TEST(BoardMessages, ImpossibleCountsAreRefused) {
  EXPECT_FALSE(readable(identity(), [](Identity& i) { i.n_a = 3; }));
  EXPECT_FALSE(readable(identity(), [](Identity& i) { i.n_q = kMaxDofs + 1; }));
  EXPECT_FALSE(readable(identity(), [](Identity& i) { i.watchdog_us = 0; }));
  Bytes lying = test::vector("STATE").payload;
  lying[20] = 3;  // n_q, of a payload that has two
  EXPECT_FALSE(read<State>(lying));
}

TEST(BoardMessages, ADofNeedsRangeAndLimit) {
  const Dof good{0, false, true, 0.0F, 0.05F, 40.0F, 0.03125F, "l_x"};
  EXPECT_FALSE(readable(good, [](Dof& dof) { dof.upper = dof.lower; }));
  EXPECT_FALSE(readable(good, [](Dof& dof) { dof.max_effort = 0.0F; }));
  EXPECT_FALSE(readable(good, [](Dof& dof) { dof.name.clear(); }));
}

TEST(BoardMessages, TextIsCleanedWhereItEnters) {
  const std::pair<const char*, const char*> texts[] = {
      {"HX-0001 ~", "HX-0001 ~"},    {"\xff\xfe\xfd", "???"}, {"a\x1b[31mb", "a?[31mb"},
      {"line\nother", "line?other"}, {"\xc2\x9b", "??"},      {"\u202e", "???"},
      {"\x7f\t\x01", "???"},         {"%s%n{}", "%s%n{}"},    {"M\xc3\xbcller", "M??ller"}};
  for (const auto& [said, heard] : texts) {
    Identity i = identity();
    i.serial = i.model = said;
    const auto back = read<Identity>(bytes_of(i));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->serial, heard);
    EXPECT_EQ(back->model, heard);
    Dof dof{0, false, false, 0.0F, 0.05F, 0.0F, 0.0F, said};
    EXPECT_EQ(read<Dof>(bytes_of(dof))->name, heard);
  }
}

TEST(BoardMessages, TheLargestDeviceFits) {
  State s = state();
  s.n_q = s.n_f = kMaxDofs;
  s.q.fill(1.0F);
  s.force.fill(2.0F);
  const auto back = read<State>(bytes_of(s));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->q[kMaxDofs - 1], 1.0F);
  EXPECT_EQ(back->force[kMaxDofs - 1], 2.0F);
}

}  // namespace
}  // namespace haptic::hw::board
