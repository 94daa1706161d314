#include "server/owner/telemetry/recorder.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/replay/replay.hpp"
#include "server/owner/state/state_message.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/temporary_file.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::ProjectionStatus;
using haptic::core::TickRecord;
using haptic::core::TimePoint;
using haptic::server::Recorder;
using haptic::test::DeviceRig;
using haptic::test::rig_config;
using haptic::test::TemporaryFile;

using Fields = std::vector<std::string>;

haptic::server::NewFile emptied(const TemporaryFile& file) {
  return haptic::server::create_file(file.path(), true);
}

Fields split(const std::string& line) {
  Fields fields;
  std::stringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  if (!line.empty() && line.back() == ',') fields.emplace_back();
  return fields;
}

/// The file as one map per row: column name -> text.
std::vector<std::map<std::string, std::string>> read_csv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const Fields names = split(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(file, line)) {
    const Fields values = split(line);
    EXPECT_EQ(values.size(), names.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
      row[names[i]] = values[i];
    }
  }
  return rows;
}

TEST(Recorder, HeaderNamesDofsAndUnits) {
  const auto kinematics = haptic::core::make_finger_exoskeleton({});
  const std::string header = Recorder::header(*kinematics, false);
  EXPECT_THAT(header, testing::StartsWith("time_s,seq,server_time_ns,state,mode,"));
  EXPECT_THAT(
      header,
      testing::HasSubstr(
          ",lease_epoch,l_x,q_B,q_dot_l_x_m_per_s,x_probe_q_o1_mcp_rad,"
          "x_probe_q_o2_pip_rad,x_q_o1_mcp_rad,x_q_o2_pip_rad,q_star_l_x_m,q_star_q_B_rad,"
          "tau_a_l_x_n,tau_elastic_l_x_n,error_bound_l_x_n,stiffness_in_effect_l_x_n_per_m,"));
  EXPECT_THAT(header, testing::HasSubstr(",drive_l_x,temperature_c_l_x,reading_l_x_m,"));
  EXPECT_THAT(header, testing::EndsWith(",damping_gain,tau_damping_l_x_n,lateness_us,skipped"));
  EXPECT_THAT(Recorder::header(*kinematics, true),
              testing::EndsWith(",skipped,tau_standard_l_x_n,tau_null_space_l_x_n,"
                                "tau_subspace_linear_l_x_n,tau_subspace_exact_l_x_n"));
}

/// The rig has two DoFs, one of them actuated, and two coordinates.
TEST(Recorder, HeaderHasEveryFieldOfState) {
  const Fields header = split(Recorder::header(*rig_config().kinematics, false));
  for (const haptic::schema::Leaf& leaf :
       haptic::schema::leaves(*haptic::v1::DeviceState::descriptor())) {
    if (leaf.name == "q") continue;  // bare names of DoFs: ReplayedDevicePlaysARecording
    const auto columns = std::count_if(header.begin(), header.end(), [&](const auto& column) {
      const bool scalar = leaf.axis == haptic::v1::AXIS_UNSPECIFIED;
      return column == leaf.name || column.rfind(leaf.name + "_slide", 0) == 0 ||
             column.rfind(leaf.name + "_swing", 0) == 0 ||
             column.rfind(leaf.name + (scalar ? "_" : "_a_"), 0) == 0 ||
             (!scalar && column.rfind(leaf.name + "_b_", 0) == 0);
    });
    EXPECT_GE(columns,
              leaf.axis == haptic::v1::AXIS_DOF || leaf.axis == haptic::v1::AXIS_COORDINATE ? 2 : 1)
        << leaf.name;
  }
}

TickRecord record_with_everything() {
  TickRecord record;
  record.input.now = TimePoint(1h);
  record.proxy.mode = haptic::core::ProxyMode::kFree;
  record.input.loop = {12500ns, 3};
  record.beat.tick = 42;
  record.life.state = haptic::core::LifecycleState::kFault;
  record.proxy.level = haptic::core::Staleness::kFade;
  record.proxy.age = 120500us;
  record.life.faults.set(haptic::core::Fault::kDeviceLost);
  record.life.faults.set(haptic::core::Fault::kEmergencyStop);
  record.effort.limiters.set(haptic::core::Limiter::kSlew);
  record.anchor.projection = ProjectionStatus::kIllConditioned;
  record.life.gain = 0.5;
  record.life.damping_gain = 1.0 / 3.0;
  record.sensed.q = (haptic::core::VecQ(2) << 0.1, -0.2).finished();
  record.effort.q_star = (haptic::core::VecQ(2) << 0.3, 0.4).finished();
  record.anchor.x_probe = (haptic::core::VecX(2) << 0.5, 0.6).finished();
  record.sensed.q_a_dot = haptic::core::VecA::Constant(1, 0.7);
  record.effort.tau_a = haptic::core::VecA::Constant(1, 0.8);
  record.effort.tau_elastic = haptic::core::VecA::Constant(1, 0.9);
  record.effort.tau_damping = haptic::core::VecA::Constant(1, 2.0 / 3.0);
  record.sensed.tracker = {true, 0, 7, haptic::core::Staleness::kHold, 3500us};
  record.effort.passivity.on = true;
  record.effort.passivity.storage = 0.25;
  record.effort.passivity.tank = -1e-7;
  return record;
}

TEST(Recorder, CellsSayWhatTheStateSays) {
  const TemporaryFile file;
  {
    haptic::v1::DeviceState state;
    Recorder recorder(emptied(file), *rig_config().kinematics, state);
    for (const TickRecord& record : {record_with_everything(), TickRecord{}}) {
      haptic::server::write({record, haptic::server::Carrier::kUdp, 9}, state);
      recorder.on_record(record);
    }
  }
  auto rows = read_csv(file.path());
  const std::pair<const char*, const char*> cells[] = {
      {"time_s", "0"},
      {"seq", "42"},
      {"state", "FAULT"},
      {"staleness", "FADE"},
      {"proxy_age_us", "120500"},
      {"mode", "FREE"},
      {"projection", "ILL_CONDITIONED"},
      {"faults", "DEVICE_LOST|EMERGENCY_STOP"},
      {"limiters", "SLEW"},
      {"lateness_us", "12.5"},
      {"skipped", "3"},
      {"x_a_m", ""},
      {"gain", "0.5"},
      {"damping_gain", "0.3333333333333333"},
      {"slide", "0.1"},
      {"swing", "-0.2"},
      {"q_star_slide_m", "0.3"},
      {"q_star_swing_m", "0.4"},
      {"x_probe_a_m", "0.5"},
      {"q_dot_slide_m_per_s", "0.7"},
      {"tau_a_slide_n", "0.8"},
      {"tau_elastic_slide_n", "0.9"},
      {"tau_damping_slide_n", "0.6666666666666666"},
      {"transport", "UDP"},
      {"lease_epoch", "9"},
      {"tracker_seq_used", "7"},
      {"tracker_age_us", "3500"},
      {"tracker_staleness", "HOLD"},
      {"passivity_tank_j", "-1e-07"},
      {"passivity_storage_j", "0.25"}};
  for (const auto& [column, text] : cells) EXPECT_EQ(rows.at(0)[column], text) << column;
  for (const char* column : {"tracker_seq_used", "passivity_storage_j", "passivity_tank_j",
                             "passivity_scale", "passivity_observed_j"}) {
    ASSERT_EQ(rows.at(1).count(column), 1u) << column;
    EXPECT_EQ(rows[1][column], "") << "what is off has no cell";
  }
}

/// /dev/full takes nothing, as a full disk.
TEST(Recorder, FullDiskRowsAreCounted) {
  const haptic::v1::DeviceState state;
  Recorder recorder({"/dev/full", ::open("/dev/full", O_WRONLY)}, *rig_config().kinematics, state);
  const TickRecord record = record_with_everything();
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (recorder.lost() == 0 && std::chrono::steady_clock::now() < give_up) {
    recorder.on_record(record);
  }
  EXPECT_GT(recorder.lost(), 0u);
  const std::uint64_t lost = recorder.lost(), rows = recorder.rows();
  for (int i = 0; i < 50; ++i) recorder.on_record(record);
  EXPECT_EQ(recorder.lost(), lost + 50);
  EXPECT_EQ(recorder.rows(), rows);
}

TEST(Recorder, ReplayedDevicePlaysARecording) {
  const TemporaryFile file;
  {
    DeviceRig rig;
    Recorder recorder(emptied(file), *rig_config().kinematics, rig.owner->newest(0));
    rig.telemetry->add(0, &recorder);
    rig.tick(10);
    rig.telemetry->remove(0, &recorder);
  }
  haptic::hw::ReplayConfig replay;
  replay.file = file.path();
  replay.max_effort = haptic::core::VecA::Constant(1, 10.0);
  const auto device = replay.open(rig_config().kinematics, {});
  EXPECT_EQ(device->info().kind, "replay");
}

}  // namespace
