// Messages and failures as JSON.
#include "server/front/web/json.hpp"

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
  EXPECT_THAT(Json::read(R"({"open": {"role": {}}})", request), HasSubstr("role"));
  EXPECT_THAT(Json::read("[", request), HasSubstr("not a SessionRequest as JSON"));
  EXPECT_NE(Json::read("{\"open\": {\"clientName\": \"\xff\"}}", request), "");
  const std::string why = Json::read("{\"\x1b[31m\n\": 1}", request);
  EXPECT_EQ(why.find_first_of("\x1b\n"), std::string::npos) << why;
}

/// The same as in binary: a newer client's fields, and its names of an enumeration, count as
/// absent.
TEST(WebJson, IgnoresWhatIsUnknown) {
  v1::SessionRequest request;
  ASSERT_EQ(Json::read(R"({"new": [{"deep": {}}], "open": {"newer": 1, "clientName": "a",
                          "role": "ROLE_NEW"}})",
                       request),
            "");
  EXPECT_EQ(request.open().client_name(), "a");
  EXPECT_EQ(request.open().role(), v1::ROLE_UNSPECIFIED);
  ASSERT_EQ(Json::read(R"({"opne": {}})", request), "");
  EXPECT_EQ(request.message_case(), v1::SessionRequest::MESSAGE_NOT_SET);
}

/// A hundred thousand brackets would cost protobuf 20 MB.
TEST(WebJson, RefusesDeepNestingUnparsed) {
  const auto nested = [](int depth, const std::string& before) {
    return "{" + before + "\"new\": " + std::string(depth - 1, '[') + std::string(depth - 1, ']') +
           "}";
  };
  v1::SessionRequest request;
  for (const char* before : {"", "'\"': 1, ", R"("\\": 1, )", R"("\"": 1, )"}) {
    EXPECT_EQ(Json::read(nested(32, before), request), "") << before;
    EXPECT_THAT(Json::read(nested(33, before), request), HasSubstr("deeper than 32")) << before;
  }
  EXPECT_EQ(Json::read(nested(32, "\"" + std::string(100, '[') + "\": '{{', "), request), "");
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
