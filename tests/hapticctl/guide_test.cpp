// A made-up device whose sensors are wrong by a known scale and offset; a script answers the guide.
#include "calibration/guide.hpp"
#include "tests/support/message_of.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <sstream>

#include "google/protobuf/text_format.h"

namespace haptic::ctl {
namespace {

/// reading = (q - offset) / scale; every answer of the script moves the device on.
struct WrongSensors final : Sensors {
  void begin() override {
    first = true;
    take();
  }
  Statistics end() override {
    take();
    return {samples, readings(q), low, high, force};
  }
  void switch_off() override { off = true; }
  void pause(double) override { take(); }

  void take() {
    std::vector<double> now = readings(q);
    if (first) low = high = now;
    first = false;
    for (const auto& place : passed) widen(readings(place));
    passed.clear();
    widen(now);
  }
  void widen(const std::vector<double>& r) {
    for (std::size_t i = 0; i < r.size(); ++i) {
      low[i] = std::min(low[i], r[i] - shake);
      high[i] = std::max(high[i], r[i] + shake);
    }
  }
  [[nodiscard]] std::vector<double> readings(const std::vector<double>& truth) const {
    return {(truth[0] - 0.004) / 1.25, (truth[1] - 0.3) / -0.8};
  }

  std::vector<double> q{0.0, 0.0};
  std::vector<std::vector<double>> passed{};  ///< between begin() and end()
  std::vector<double> low{}, high{}, force{0.7};
  double shake{0.0};
  std::uint64_t samples{500};
  bool first{true}, off{false};
};

/// An input that does something with the device before each line is read.
class Script : public std::stringbuf {
 public:
  using Step = std::pair<std::function<void()>, std::string>;
  explicit Script(std::vector<Step> steps) : steps_(std::move(steps)) {}

 protected:
  int_type underflow() override {
    if (next_ >= steps_.size()) return traits_type::eof();
    steps_[next_].first();
    str(steps_[next_++].second + "\n");
    return traits_type::to_int_type(str().front());
  }

 private:
  std::vector<Step> steps_;
  std::size_t next_{0};
};

const std::vector<client::DegreeOfFreedom> kDofs{{"l_x", "m", true, 0.0, 0.05},
                                                 {"q_B", "rad", false, -1.2, 0.7}};

struct GuideRun : ::testing::Test {
  WrongSensors device;
  std::ostringstream asked;

  auto at(double l_x, double q_B) {
    return [this, l_x, q_B] { device.q = {l_x, q_B}; };
  }
  auto through(const std::vector<std::vector<double>>& places) {
    return [this, places] { device.passed = places; };
  }
  std::vector<Script::Step> good() {
    return {{at(0.01, 0.0), "0.01"},
            {at(0.04, 0.0), "0.04"},
            {through({{0.001, 0.0}, {0.049, 0.0}}), ""},
            {at(0.02, -1.2), ""},  // Enter: its lower end
            {at(0.02, 0.7), ""},
            {through({{0.02, -1.1}, {0.02, 0.6}}), ""},
            {[this] { EXPECT_FALSE(device.off) << "the hand has not been told yet"; }, ""},
            {[this] { EXPECT_TRUE(device.off) << "before the hand lets go"; }, ""}};
  }
  v1::Calibration run(std::vector<Script::Step> steps) {
    Script script(std::move(steps));
    std::istream answers(&script);
    Guide guide(device, answers, asked);
    return guide.run(kDofs);
  }
  std::string why(std::vector<Script::Step> steps) {
    return test::message_of<CalibrationAborted>([&] { return run(std::move(steps)); });
  }
};

TEST_F(GuideRun, FindsTheSensorsMeaning) {
  const v1::Calibration result = run(good());
  ASSERT_EQ(result.dof_size(), 2);
  EXPECT_EQ(result.dof(0).name(), "l_x");
  EXPECT_NEAR(result.dof(0).scale(), 1.25, 1e-12);
  EXPECT_NEAR(result.dof(0).offset(), 0.004, 1e-12);
  EXPECT_NEAR(result.dof(0).lower(), 0.001, 1e-12);
  EXPECT_NEAR(result.dof(0).upper(), 0.049, 1e-12);
  // A sensor that counts the other way: the ends of its readings change places.
  EXPECT_NEAR(result.dof(1).scale(), -0.8, 1e-12);
  EXPECT_NEAR(result.dof(1).offset(), 0.3, 1e-12);
  EXPECT_NEAR(result.dof(1).lower(), -1.1, 1e-12);
  EXPECT_NEAR(result.dof(1).upper(), 0.7, 1e-12) << "where it stood when the travel began";
  EXPECT_THAT(result.force_zero(), testing::ElementsAre(0.7));
}

TEST_F(GuideRun, AsksAgainForAnUnusableAnswer) {
  const auto shaken = [this] { device.q = {0.01, 0.0}, device.shake = 0.001; };
  const auto still = [this] { device.q = {0.01, 0.0}, device.shake = 0.0; };
  const struct {
    std::vector<Script::Step> first;
    const char* says;
  } table[] = {
      {{{at(0.01, 0.0), "one"}}, "'one' is no number"},
      {{{shaken, "0.01"}, {still, "0.01"}, {at(0.01, 0.0), "0.01"}}, "hold it still"},
      {{{at(0.010, 0.0), "0.010"}, {at(0.012, 0.0), "0.012"}}, "both must differ"},
  };
  for (const auto& [first, says] : table) {
    device.off = false;
    auto steps = good();
    steps.insert(steps.begin(), first.begin(), first.end());
    EXPECT_NEAR(run(steps).dof(0).scale(), 1.25, 1e-9) << says;
    EXPECT_NE(asked.str().find(says), std::string::npos) << asked.str();
  }
}

TEST_F(GuideRun, RefusesASensorThatStandsStill) {
  std::vector<Script::Step> steps;
  for (int i = 0; i < 2 * Guide::kTries; ++i) {
    steps.emplace_back(at(0.02, 0.0), i % 2 == 0 ? "0.0" : "0.05");
  }
  EXPECT_EQ(why(steps), "l_x: the two places were never far enough apart");
}

TEST_F(GuideRun, QuestionsTravelBeyondTheRange) {
  auto steps = good();
  steps[2] = {through({{-0.02, 0.0}, {0.049, 0.0}}), ""};
  const auto within = [this] { device.passed = {{0.0, 0.0}, {0.05, 0.0}}; };
  steps.insert(steps.begin() + 3, {within, ""});
  EXPECT_NEAR(run(steps).dof(0).lower(), 0.0, 1e-12);
  EXPECT_NE(asked.str().find("were the two places right?"), std::string::npos);
}

TEST_F(GuideRun, GivesUpOnASilentDevice) {
  device.samples = 3;
  std::vector<Script::Step> steps(Guide::kTries, {at(0.01, 0.0), "0.01"});
  EXPECT_EQ(why(steps), "l_x: no place was found in 5 tries");
  EXPECT_NE(asked.str().find("only 3 samples"), std::string::npos);
}

TEST_F(GuideRun, EndsWhenToldTo) {
  EXPECT_EQ(why({{at(0.0, 0.0), "q"}}), "given up");
  EXPECT_EQ(why({}), "the answers ended");
}

TEST(CalibrationFile, HoldsEveryNumberToTheBit) {
  v1::Calibration written, read;
  written.set_device_serial("HX-\"1\"");
  written.set_date("2026-11-21");
  v1::Calibration::Dof& dof = *written.add_dof();
  dof.set_name("l_x");
  dof.set_scale(1.0 / 3.0);
  dof.set_offset(-0.1);
  written.add_force_zero(0.1 + 0.2);
  const std::string text = to_textproto(written);
  EXPECT_THAT(text, testing::StartsWith("# proto-file: haptic/v1/calibration.proto\n"
                                        "# proto-message: haptic.v1.Calibration\n"));
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &read));
  EXPECT_EQ(read.SerializeAsString(), written.SerializeAsString());
}

}  // namespace
}  // namespace haptic::ctl
