#include "server/owner/scene/removed.hpp"

#include <google/protobuf/descriptor.h>

#include <functional>
#include <set>

#include "haptic/v1/scene.pb.h"
#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

const std::string kAdvice = "`coupling_metric` was removed in 0.1.0: delete the line; ";

TEST(RemovedField, SceneSaysWhatToDo) {
  expect_says(with_option(kFinger, "coupling_metric { softness: 0.1 }"),
              "t.textproto:9:3: " + kAdvice);
  EXPECT_EQ(error_of(with_option(kFinger, "# coupling_metric {}")), "no error");
  EXPECT_EQ(error_of(replaced(kFinger, "\"t\"", "'coupling_metric: {}'")), "no error");
}

TEST(RemovedField, OverrideSaysWhatToDo) {
  for (const std::string set : {"device[0].coupling_metric={}", "device[0].coupling_metric.x=1",
                                "device[0]={name: 'd' coupling_metric {}}"}) {
    expect_says(kFinger, "--set " + set + ": ", {set});
    expect_says(kFinger, kAdvice, {set});
  }
}

TEST(RemovedField, EveryReservedNameHasAdvice) {
  std::set<std::string> seen, removed;
  const std::function<void(const google::protobuf::Descriptor&)> visit = [&](const auto& message) {
    if (!seen.insert(message.full_name()).second) return;
    for (int i = 0; i < message.reserved_name_count(); ++i)
      removed.insert(message.reserved_name(i));
    for (int i = 0; i < message.field_count(); ++i) {
      if (const auto* inner = message.field(i)->message_type()) visit(*inner);
    }
  };
  visit(*v1::Scene::descriptor());
  EXPECT_EQ(removed.count("coupling_metric"), 1U);
  for (const std::string& name : removed) EXPECT_NE(server::removed_field(name), "") << name;
}

TEST(RemovedField, OthersHaveNone) {
  EXPECT_EQ(server::removed_field("direction_guard"), "");
}

}  // namespace
}  // namespace haptic::test
