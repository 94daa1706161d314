#include "server/owner/telemetry/recorder.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
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
using haptic::server::RendererComparison;
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

double number(const std::string& text) {
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  EXPECT_TRUE(error == std::errc() && end == text.data() + text.size()) << "'" << text << "'";
  return value;
}

/// The state as the owner has it, without carrier and lease.
Recorder::StateOf states() {
  return [state = std::make_shared<haptic::v1::DeviceState>()](
             const TickRecord& record) -> const haptic::v1::DeviceState& {
    haptic::server::write({record}, *state);
    return *state;
  };
}

#define EXPECT_SAME_BITS(text, expected)                                                        \
  EXPECT_EQ(std::bit_cast<std::uint64_t>(number(text)), std::bit_cast<std::uint64_t>(expected)) \
      << (text) << " and " << (expected)

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

TEST(Recorder, TrackersPoseInUseIsRecorded) {
  const TemporaryFile file;
  {
    Recorder recorder(emptied(file), *rig_config().kinematics, states());
    TickRecord record;
    recorder.on_record(record);
    record.sensed.q = haptic::core::VecQ::Zero(2);
    record.sensed.tracker.on = true;
    record.sensed.tracker.seq = 7;
    record.sensed.tracker.age = 3500us;
    record.sensed.tracker.level = haptic::core::Staleness::kHold;
    recorder.on_record(record);
  }
  auto rows = read_csv(file.path());
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["tracker_seq_used"], "");
  EXPECT_EQ(rows[1]["tracker_seq_used"], "7");
  EXPECT_EQ(rows[1]["tracker_age_us"], "3500");
  EXPECT_EQ(rows[1]["tracker_staleness"], "HOLD");
}

TEST(Recorder, CarrierAndLeaseAreRecorded) {
  const TemporaryFile file;
  {
    const TickRecord record;
    haptic::v1::DeviceState state;
    haptic::server::write({record, haptic::server::Carrier::kUdp, 9}, state);
    Recorder recorder(emptied(file), *rig_config().kinematics,
                      [&](const TickRecord&) -> const haptic::v1::DeviceState& { return state; });
    recorder.on_record(record);
  }
  auto row = read_csv(file.path()).at(0);
  EXPECT_EQ(row["transport"], "UDP");
  EXPECT_EQ(row["lease_epoch"], "9");
}

TEST(Recorder, NumbersReadBackExactly) {
  const TemporaryFile file;
  DeviceRig rig;
  struct Keeper final : haptic::server::RecordListener {
    std::vector<TickRecord> records{};
    void on_record(const TickRecord& record) override { records.push_back(record); }
  } keeper;
  {
    Recorder recorder(emptied(file), *rig_config().kinematics, states());
    rig.telemetry->add(0, &keeper);
    rig.telemetry->add(0, &recorder);
    rig.control();
    rig.press();
    rig.stream(20, 1.0 / 3.0);
    rig.telemetry->remove(0, &recorder);
    rig.telemetry->remove(0, &keeper);
    EXPECT_EQ(recorder.rows(), keeper.records.size());
  }
  const auto rows = read_csv(file.path());
  ASSERT_EQ(rows.size(), keeper.records.size());
  bool force = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto row = rows[i];
    const TickRecord& record = keeper.records[i];
    ASSERT_EQ(row["seq"], std::to_string(record.beat.tick));
    EXPECT_EQ(row["state"], haptic::core::name(record.life.state));
    EXPECT_NEAR(number(row["time_s"]), 1e-3 * static_cast<double>(i), 1e-12);
    EXPECT_SAME_BITS(row["gain"], record.life.gain);
    EXPECT_SAME_BITS(row["damping_gain"], record.life.damping_gain);
    EXPECT_SAME_BITS(row["slide"], record.sensed.q[0]);
    EXPECT_SAME_BITS(row["swing"], record.sensed.q[1]);
    EXPECT_SAME_BITS(row["q_dot_slide_m_per_s"], record.sensed.q_a_dot[0]);
    EXPECT_SAME_BITS(row["x_probe_a_m"], record.anchor.x_probe[0]);
    EXPECT_SAME_BITS(row["q_star_slide_m"], record.effort.q_star[0]);
    EXPECT_SAME_BITS(row["q_star_swing_m"], record.effort.q_star[1]);
    EXPECT_SAME_BITS(row["tau_elastic_slide_n"], record.effort.tau_elastic[0]);
    EXPECT_SAME_BITS(row["tau_damping_slide_n"], record.effort.tau_damping[0]);
    EXPECT_SAME_BITS(row["tau_a_slide_n"], record.effort.tau_a[0]);
    if (record.anchor.x.size() == 2) {
      EXPECT_SAME_BITS(row["x_a_m"], record.anchor.x[0]);
      EXPECT_SAME_BITS(row["x_b_m"], record.anchor.x[1]);
    } else {
      EXPECT_EQ(row["x_a_m"], "");
    }
    force = force || record.effort.tau_a[0] != 0.0;
  }
  EXPECT_TRUE(force);
}

TEST(Recorder, EnergyColumnsAreEmptyWithoutTank) {
  const TemporaryFile file;
  {
    Recorder recorder(emptied(file), *rig_config().kinematics, states());
    TickRecord record;
    recorder.on_record(record);
    record.effort.passivity.on = true;
    record.effort.passivity.storage = 1.0 / 3.0;
    record.effort.passivity.tank = -1e-7;
    record.effort.passivity.scale = 0.25;
    record.effort.passivity.observed = 0.1;
    recorder.on_record(record);
  }
  auto rows = read_csv(file.path());
  for (const char* name :
       {"passivity_storage_j", "passivity_tank_j", "passivity_scale", "passivity_observed_j"}) {
    ASSERT_EQ(rows.at(0).count(name), 1u) << name;
    EXPECT_EQ(rows[0][name], "");
  }
  EXPECT_SAME_BITS(rows.at(1)["passivity_storage_j"], 1.0 / 3.0);
  EXPECT_SAME_BITS(rows[1]["passivity_tank_j"], -1e-7);
  EXPECT_SAME_BITS(rows[1]["passivity_scale"], 0.25);
  EXPECT_SAME_BITS(rows[1]["passivity_observed_j"], 0.1);
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
  return record;
}

TEST(Recorder, NamesStatesLevelsFaultsAndLimiters) {
  const TemporaryFile file;
  {
    Recorder recorder(emptied(file), *rig_config().kinematics, states());
    recorder.on_record(record_with_everything());
  }
  auto row = read_csv(file.path()).at(0);
  EXPECT_EQ(row["time_s"], "0");
  EXPECT_EQ(row["seq"], "42");
  EXPECT_EQ(row["state"], "FAULT");
  EXPECT_EQ(row["staleness"], "FADE");
  EXPECT_EQ(row["proxy_age_us"], "120500");
  EXPECT_EQ(row["mode"], "FREE");
  EXPECT_EQ(row["projection"], "ILL_CONDITIONED");
  EXPECT_EQ(row["faults"], "DEVICE_LOST|EMERGENCY_STOP");
  EXPECT_EQ(row["limiters"], "SLEW");
  EXPECT_EQ(row["lateness_us"], "12.5");
  EXPECT_EQ(row["skipped"], "3");
  EXPECT_EQ(row["x_a_m"], "");
}

/// /dev/full takes nothing, as a full disk.
TEST(Recorder, FullDiskEndsOnlyTheRecording) {
  DeviceRig rig;
  struct Counter final : haptic::server::RecordListener {
    std::size_t records{0};
    void on_record(const TickRecord& /*record*/) override { ++records; }
  } after;
  Recorder recorder({"/dev/full", ::open("/dev/full", O_WRONLY)}, *rig_config().kinematics,
                    states());
  rig.telemetry->add(0, &recorder);
  rig.telemetry->add(0, &after);
  rig.control();
  rig.press();
  std::size_t ticks = after.records;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (recorder.lost() == 0 && std::chrono::steady_clock::now() < give_up) {
    rig.stream(1, 1.0 / 3.0);
    ++ticks;
  }
  EXPECT_GT(recorder.lost(), 0u);
  const std::uint64_t lost = recorder.lost(), rows = recorder.rows();
  rig.stream(50, 1.0 / 3.0);
  EXPECT_EQ(recorder.lost(), lost + 50);
  EXPECT_EQ(recorder.rows(), rows);
  EXPECT_EQ(after.records, ticks + 50);  // those who listen after it hear every tick
  EXPECT_NE(rig.newest().effort.tau_a[0], 0.0);
  rig.telemetry->remove(0, &recorder);
  rig.telemetry->remove(0, &after);
}

TEST(Recorder, ReplayedDevicePlaysARecording) {
  const TemporaryFile file;
  {
    DeviceRig rig;
    Recorder recorder(emptied(file), *rig_config().kinematics, states());
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

/// A tick of the rig's map (x = q), 100 N/m, 10 N: proxy 2 cm from the probe at q = 0.
TickRecord pressing(double gain, double x) {
  TickRecord record;
  record.input.settings = rig_config().scene;
  record.anchor.projection = ProjectionStatus::kExact;
  record.life.gain = gain;
  record.sensed.q = haptic::core::VecQ::Zero(2);
  record.anchor.x = haptic::core::VecX::Zero(2);
  record.anchor.x[0] = x;
  return record;
}

// Where the map is the identity nothing couples the DoFs: all four methods are the same spring.
TEST(RendererComparison, AllAgreeOnTheIdentityMap) {
  RendererComparison comparison(rig_config().kinematics);
  for (const auto& tau : comparison.evaluate(pressing(1.0, 0.02))) EXPECT_NEAR(tau[0], 2.0, 1e-12);
  for (const auto& tau : comparison.evaluate(pressing(0.25, 0.02))) EXPECT_NEAR(tau[0], 0.5, 1e-12);
}

TEST(RendererComparison, EveryForceObeysGainTimesLimit) {
  RendererComparison comparison(rig_config().kinematics);
  for (const auto& tau : comparison.evaluate(pressing(0.5, 0.4))) EXPECT_EQ(tau[0], 5.0);
  for (const auto& tau : comparison.evaluate(pressing(0.5, -0.4))) EXPECT_EQ(tau[0], -5.0);
}

TEST(RendererComparison, UsesASessionsTighterSettings) {
  RendererComparison comparison(rig_config().kinematics);
  TickRecord record = pressing(1.0, 0.02);
  record.input.settings.stiffness[0] = 50.0;
  for (const auto& tau : comparison.evaluate(record)) EXPECT_NEAR(tau[0], 1.0, 1e-12);
}

TEST(RendererComparison, IsZeroWithoutAProxy) {
  RendererComparison comparison(rig_config().kinematics);
  TickRecord record = pressing(1.0, 0.02);
  record.anchor.projection = ProjectionStatus::kNone;
  for (const auto& tau : comparison.evaluate(record)) EXPECT_EQ(tau[0], 0.0);
}

TEST(RendererComparison, ImpossibleLinkageIsNotANumber) {
  const std::shared_ptr<const haptic::core::Kinematics> kinematics =
      haptic::core::make_finger_exoskeleton(haptic::core::finger_sign_change());
  haptic::core::RenderSettings scene{.stiffness = haptic::core::VecA::Constant(1, 1500.0),
                                     .force_limit = haptic::core::VecA::Constant(1, 25.0)};
  RendererComparison comparison(kinematics);
  TickRecord record = pressing(1.0, 0.02);
  record.input.settings = scene;
  record.anchor.projection = ProjectionStatus::kMapFailed;
  record.sensed.q[0] = 0.02;
  record.sensed.q[1] = -101.0 * 3.14159265358979 / 180.0;  // the rods do not reach
  for (const auto& tau : comparison.evaluate(record)) EXPECT_TRUE(std::isnan(tau[0]));
}

}  // namespace
