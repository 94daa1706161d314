// The table of hapticctl watch for a state, against the list of the fields that it has.
#include "table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "client/src/convert.hpp"
#include "message_json.hpp"

namespace haptic::ctl {
namespace {

using testing::HasSubstr;

client::DeviceInfo slider() {
  client::DeviceInfo device;
  device.name = "rig";
  device.dofs = {{"slide", "m", true, 0.0, 0.1, 10.0}, {"swing", "rad", false, -1.0, 1.0, 0.0}};
  device.coordinates = {{"x", "m", "linear"}, {"phi", "rad", "angle"}};
  device.force_limit = {10.0};
  return device;
}

/// Every field is present.
v1::DeviceState full_message() {
  v1::DeviceState message;
  message.set_mode(v1::PROXY_MODE_FREE);
  message.mutable_passivity();
  message.mutable_tracker()->set_seq_used(7);
  message.add_actuator_limiters(6);
  for (auto* actuated :
       {message.mutable_q_dot(), message.mutable_tau_a(), message.mutable_tau_elastic()}) {
    actuated->Add(5.0);
  }
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const auto* const field = message.GetDescriptor()->field(i);
    if (!field->is_repeated() || reflection.FieldSize(message, field) > 0) continue;
    for (const double value : {0.125, -2.5}) reflection.AddDouble(&message, field, value);
  }
  return message;
}

client::DeviceState full_state() {
  return client::to_state(full_message());
}

/// Names of the fields, and of those of the messages in it.
std::vector<std::string> names_in(const google::protobuf::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) {
    names.push_back(type.field(i)->name());
    if (type.field(i)->message_type() == nullptr) continue;
    for (std::string& inner : names_in(*type.field(i)->message_type())) {
      names.push_back(std::move(inner) + " ");
    }
  }
  return names;
}

std::string shown(const client::DeviceState& state, std::size_t width,
                  const client::DeviceInfo& device = slider()) {
  std::string all;
  for (const std::string& row : table(device, state, 1.5, 3, width)) all += row + "\n";
  return all;
}

TEST(Table, ShowsEveryFieldOfAState) {
  const std::string all = shown(full_state(), 100);
  for (const std::string& name : names_in(*v1::DeviceState::descriptor())) {
    EXPECT_THAT(all, HasSubstr(name));
  }
}

TEST(Table, NamesDofsAndCoordinatesWithUnits) {
  const std::string all = shown(full_state(), 200);
  EXPECT_THAT(all, testing::ContainsRegex("  q  +slide 0.125 m  swing -2.5 rad\n"));
  EXPECT_THAT(all, testing::ContainsRegex("  x_probe  +x 0.125 m  phi -2.5 rad\n"));
  EXPECT_THAT(all, testing::ContainsRegex("  tau_a  +slide 5 N\n"));
  EXPECT_THAT(all, HasSubstr("SLEW|ENVELOPE"));
}

TEST(Table, SaysWhyStiffnessIsDerated) {
  client::DeviceInfo device = slider();
  device.stiffness_limit = {1500.0};
  client::DeviceState state = full_state();
  EXPECT_THAT(line(device, state, 1.5), testing::Not(HasSubstr("K slide")));
  state.gain = 0.5;
  state.stiffness_in_effect = {410.0};
  state.derating = client::Derating::kHeld;
  state.derating_delay = std::chrono::milliseconds(50);
  const char* const kWords = "  K slide 1500 -> 820 N/m: proxy held, 50 ms old";
  EXPECT_THAT(line(device, state, 1.5), HasSubstr(kWords));
  EXPECT_THAT(shown(state, 79, device), HasSubstr(std::string(kWords) + "\n"));
}

TEST(Table, SaysWhatLimitsMean) {
  client::DeviceState state = full_state();
  state.limiters = 1U << 5 | 1U << 19;
  const char* const sentences[] = {
      "Energy tank is empty: A change is held back; allowed_power_w would allow more.",
      "Samples come too fast: More than twice as many as announced are not fresh."};
  for (const std::string sentence : sentences) {
    EXPECT_THAT(line(slider(), state, 1.5), HasSubstr("  " + sentence));
    EXPECT_THAT(shown(state, 200), HasSubstr("  " + sentence + "\n"));
  }
  EXPECT_THAT(shown(state, 79), HasSubstr("would allow\n    more."));
}

TEST(Table, KeepsWithinItsWidth) {
  for (const std::string& row : table(slider(), full_state(), 1.5, 3, 79)) {
    EXPECT_LE(row.size(), 79u) << row;
  }
}

TEST(Table, AbsentFieldsHaveNoColumn) {
  v1::DeviceState message = full_message();
  message.clear_temperature_c();
  message.clear_passivity();
  const std::string all = shown(client::to_state(message), 100);
  EXPECT_THAT(all, testing::Not(HasSubstr("temperature_c")));
  EXPECT_THAT(all, testing::Not(HasSubstr("passivity")));
}

TEST(Line, NamesEachDof) {
  const std::string all = line(slider(), full_state(), 1.5);
  EXPECT_THAT(all, HasSubstr("slide  0.12500 m swing -2.50000 rad  tau_a slide   5.000 N"));
  EXPECT_THAT(all, HasSubstr("no proxy  gain"));
  EXPECT_THAT(all, HasSubstr("  pose UNKNOWN, age 0.0 ms"));
}

TEST(JsonLine, HasEveryFieldOfAState) {
  const auto json = state_json(slider(), full_state());
  const auto& type = *v1::DeviceState::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    ASSERT_TRUE(json.contains(type.field(i)->name())) << type.field(i)->name();
    EXPECT_FALSE(json[type.field(i)->name()].is_null()) << type.field(i)->name();
  }
  EXPECT_EQ(json["q"], (nlohmann::json{0.125, -2.5}));
  EXPECT_EQ(json["actuator_limiters"], nlohmann::json::parse(R"([["SLEW", "ENVELOPE"]])"));
  EXPECT_EQ(json["mode"], "FREE");
}

TEST(JsonLine, AbsentMessagesAndNansAreNull) {
  v1::DeviceState message = full_message();
  message.clear_passivity();
  message.set_temperature_c(0, std::nan(""));
  const auto json = state_json(slider(), client::to_state(message));
  EXPECT_TRUE(json["passivity"].is_null());
  EXPECT_TRUE(json["temperature_c"][0].is_null());
}

TEST(JsonLine, DurationsAreNumbersOfMicroseconds) {
  v1::LinkDirection message;
  message.mutable_jitter()->set_nanos(2500);
  message.add_rejected()->set_reason("TAG");
  const auto json = to_json(message);
  EXPECT_EQ(json["jitter_us"], 2.5);
  EXPECT_TRUE(json["longest_gap_us"].is_null());
  EXPECT_EQ(json["rejected"][0]["reason"], "TAG");
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
