// What hapticctl watch shows of a state, against the list of the fields that it has.
#include "table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "haptic/client/state_fields.hpp"

namespace haptic::ctl {
namespace {

using testing::HasSubstr;

client::DeviceInfo slider() {
  client::DeviceInfo device;
  device.name = "rig";
  device.dofs = {{"slide", "m", true, 0.0, 0.1, 10.0}, {"swing", "rad", false, -1.0, 1.0, 0.0}};
  device.coordinates = {{"x", "m", "linear"}, {"phi", "rad", "angle"}};
  device.force_limit = {10.0};
  device.tracker = "camera";
  return device;
}

/// Every field is present.
client::DeviceState full_state() {
  client::DeviceState state;
  state.passivity.emplace();
  state.tracker.emplace().seq_used = 7;
  state.certificate.emplace();
  state.coupling_metric = {{2, {1.0, 0.5, 2.0}}};
  client::DeviceState::for_each(state, [](const char*, auto& member) {
    using Member = std::remove_reference_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, std::vector<double>>) member = {0.125, -2.5};
    if constexpr (std::is_same_v<Member, std::vector<std::uint32_t>>) member = {6};
  });
  for (auto* actuated : {&state.q_dot, &state.tau_a, &state.tau_elastic}) *actuated = {5.0};
  return state;
}

std::string shown(const client::DeviceState& state, std::size_t width) {
  std::string all;
  for (const std::string& row : table(slider(), state, 1.5, 3, width)) all += row + "\n";
  return all;
}

TEST(Table, ShowsEveryFieldOfAState) {
  const std::string all = shown(full_state(), 100);
  for (const client::StateField& field : client::state_fields(slider(), full_state())) {
    EXPECT_THAT(all, HasSubstr(field.name));
    for (const client::StateField& inner :
         field.messages.empty() ? std::vector<client::StateField>{} : field.messages.front()) {
      EXPECT_THAT(all, HasSubstr(inner.name + " ")) << field.name;
    }
  }
}

TEST(Table, NamesDofsAndCoordinatesWithUnits) {
  const std::string all = shown(full_state(), 200);
  EXPECT_THAT(all, testing::ContainsRegex("slide +0.125 m +5 m/s +0.125 m +5 N +5 N"));
  EXPECT_THAT(all, testing::ContainsRegex("swing +-2.5 rad"));
  EXPECT_THAT(all, testing::ContainsRegex("phi +-2.5 rad +-2.5 rad"));
  EXPECT_THAT(all, HasSubstr("[            |######      ]"));  // half of the force limit
  EXPECT_THAT(all, HasSubstr("SLEW|ENVELOPE"));
}

TEST(Table, KeepsWithinItsWidth) {
  for (const std::string& row : table(slider(), full_state(), 1.5, 3, 79)) {
    EXPECT_LE(row.size(), 79u) << row;
  }
}

TEST(Table, AbsentFieldsHaveNoColumn) {
  client::DeviceState state = full_state();
  state.temperature_c.clear();
  state.passivity.reset();
  EXPECT_THAT(shown(state, 100), testing::Not(HasSubstr("temperature_c")));
  EXPECT_THAT(shown(state, 100), testing::Not(HasSubstr("passivity")));
}

TEST(Line, NamesEachDof) {
  const std::string all = line(slider(), full_state(), 1.5);
  EXPECT_THAT(all, HasSubstr("slide  0.12500 m swing -2.50000 rad  tau_a slide   5.000 N"));
  EXPECT_THAT(all, HasSubstr("tracker camera, pose 7"));
}

TEST(JsonLine, HasEveryFieldOfAState) {
  const auto json = nlohmann::json::parse(json_line(slider(), full_state(), 3));
  for (const client::StateField& field : client::state_fields(slider(), full_state())) {
    ASSERT_TRUE(json.contains(field.name)) << field.name;
    EXPECT_FALSE(json[field.name].is_null()) << field.name;
  }
  EXPECT_EQ(json["q"], (nlohmann::json{0.125, -2.5}));
  EXPECT_EQ(json["actuator_limiters"], nlohmann::json::parse(R"([["SLEW", "ENVELOPE"]])"));
  EXPECT_EQ(json["coupling_metric"][0]["lower"], (nlohmann::json{1.0, 0.5, 2.0}));
  EXPECT_EQ(json["tracker"]["holder"], "camera");
  EXPECT_EQ(json["mode"], "FREE");
}

TEST(JsonLine, AbsentMessagesAndNansAreNull) {
  client::DeviceState state = full_state();
  state.passivity.reset();
  state.temperature_c = {std::nan("")};
  const auto json = nlohmann::json::parse(json_line(slider(), state, 3));
  EXPECT_TRUE(json["passivity"].is_null());
  EXPECT_TRUE(json["temperature_c"][0].is_null());
}

TEST(JsonFields, SayAxisLabelsAndUnits) {
  const nlohmann::json fields = json_fields(slider());
  const auto tau = std::find_if(fields.begin(), fields.end(),
                                [](const auto& field) { return field["name"] == "tau_a"; });
  ASSERT_NE(tau, fields.end());
  EXPECT_EQ(*tau,
            (nlohmann::json{
                {"name", "tau_a"}, {"axis", "actuated"}, {"labels", {"slide"}}, {"units", {"N"}}}));
}

}  // namespace
}  // namespace haptic::ctl
