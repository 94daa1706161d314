/// A field of the state that only this test declares (add_field.py) has its value in everything
/// that is made of the messages. new_field_test.py goes on with the bytes in C#, JavaScript and
/// Python.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "client/c/src/state_struct.hpp"
#include "client/hapticctl/table.hpp"
#include "client/src/convert_state.hpp"
#include "haptic/client/types.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "server/owner/state/state_message.hpp"
#include "server/owner/telemetry/recorder.hpp"

namespace haptic {
namespace {

constexpr double kScalar = 0.625, kListed = -1.5;

core::TickRecord record() {
  core::TickRecord record;
  record.life.gain = kScalar;
  record.effort.tau_a = core::VecA::Constant(1, kListed);
  return record;
}

v1::DeviceState message() {
  const core::TickRecord made = record();
  v1::DeviceState state;
  server::write({made}, state);
  return state;
}

client::DeviceState state() {
  client::DeviceState state;
  client::read(message(), state);
  return state;
}

client::DeviceInfo device() {
  client::DeviceInfo device;
  device.dofs = {{"slide", "m", true, 0.0, 0.1, 10.0}};
  return device;
}

TEST(NewField, CrossesToTheFront) {
  const core::TickRecord made = record();
  server::SerialisedState serialised;
  server::serialise(made, message(), serialised);
  const auto bytes = serialised.message();
  v1::DeviceState got;
  ASSERT_TRUE(got.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
  EXPECT_EQ(got.tested(), kScalar);
  ASSERT_EQ(got.tested_list_size(), 1);
  EXPECT_EQ(got.tested_list(0), kListed);
  std::ofstream(HAPTIC_STATE_BYTES ".message", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

TEST(NewField, IsAMemberInCpp) {
  EXPECT_EQ(state().tested, kScalar);
  EXPECT_EQ(state().tested_list, std::vector<double>{kListed});
}

TEST(NewField, IsAtTheEndInC) {
  haptic_state c{};
  c::write(state(), c);
  EXPECT_EQ(c.tested, kScalar);
  EXPECT_EQ(c.tested_list.count, 1U);
  EXPECT_EQ(c.tested_list.value[0], kListed);
  EXPECT_GT(offsetof(haptic_state, tested), offsetof(haptic_state, derating_delay_us));
  EXPECT_GT(offsetof(haptic_state, tested), offsetof(haptic_state, unexplained));
  std::ofstream(HAPTIC_STATE_BYTES ".struct", std::ios::binary)
      .write(reinterpret_cast<const char*>(&c), sizeof c);
}

TEST(NewField, IsARowOfWatch) {
  std::string shown;
  for (const std::string& row : ctl::table(device(), state(), 0.0, 0, 100)) shown += row + "\n";
  EXPECT_NE(shown.find("tested"), std::string::npos) << shown;
  EXPECT_NE(shown.find("0.625 N"), std::string::npos) << shown;
  EXPECT_NE(shown.find("-1.5"), std::string::npos) << shown;
}

TEST(NewField, IsAColumnOfRecordings) {
  const auto finger = core::make_finger_exoskeleton({});
  const std::string path = HAPTIC_STATE_BYTES ".csv";
  const v1::DeviceState made = message();
  {
    server::Recorder recorder(server::create_file(path, true), *finger, made);
    recorder.on_record(record());
  }
  std::ifstream file(path);
  std::string names, cells, name, cell;
  std::getline(file, names);
  std::getline(file, cells);
  std::istringstream name_list(names), cell_list(cells);
  int found = 0;
  while (std::getline(name_list, name, ',') && std::getline(cell_list, cell, ',')) {
    if (name != "tested_n" && name != "tested_list_l_x_n") continue;
    ++found;
    EXPECT_EQ(cell, name == "tested_n" ? "0.625" : "-1.5");
  }
  EXPECT_EQ(found, 2) << names;
}

}  // namespace
}  // namespace haptic
