// Messages and failures as JSON.
#include "server/web/json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "haptic/v1/session.pb.h"

namespace haptic::server {
namespace {

using testing::HasSubstr;

v1::SessionResponse state_of(double value) {
  v1::SessionResponse response;
  response.mutable_state()->set_seq(1ULL << 60U);
  response.mutable_state()->add_q(value);
  return response;
}

TEST(WebJson, PrintsEveryDigitOfADouble) {
  const Json json;
  for (const double value : {0.1, 1.0 / 3.0, 4.9e-324, -1.7976931348623157e308}) {
    const std::string text =
        json.from_bytes(*v1::SessionResponse::descriptor(), state_of(value).SerializeAsString());
    v1::SessionResponse back;
    ASSERT_EQ(Json::read(text, back), "") << text;
    EXPECT_EQ(back.state().q(0), value) << text;
    EXPECT_EQ(back.state().seq(), 1ULL << 60U);
  }
}

TEST(WebJson, SaysWhatCannotBeRead) {
  v1::SessionRequest request;
  EXPECT_THAT(Json::read(R"({"opne": {}})", request), HasSubstr("opne"));
  EXPECT_THAT(Json::read("[", request), HasSubstr("not a SessionRequest as JSON"));
  EXPECT_NE(Json::read(std::string(60000, '['), request), "");
  EXPECT_NE(Json::read("{\"open\": {\"clientName\": \"\xff\"}}", request), "");
  const std::string why = Json::read("{\"\x1b[31m\n\": 1}", request);
  EXPECT_EQ(why.find_first_of("\x1b\n"), std::string::npos) << why;
}

TEST(WebJson, FailureSaysCodeAndReason) {
  const auto error = nlohmann::json::parse(
      connect_error({Refusal::Code::kNotFound, "NO_SUCH_DEVICE", "no device \"x\""}));
  EXPECT_EQ(error["code"], "not_found");
  EXPECT_EQ(error["message"], "no device \"x\"");
  EXPECT_EQ(error["details"][0]["type"], "google.rpc.ErrorInfo");
  EXPECT_EQ(error["details"][0]["debug"]["reason"], "NO_SUCH_DEVICE");
  EXPECT_EQ(http_status(Refusal::Code::kNotFound), 404U);
  EXPECT_EQ(http_status(Refusal::Code::kUnauthenticated), 401U);
}

}  // namespace
}  // namespace haptic::server
