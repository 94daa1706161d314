#pragma once
/// Messages as protobuf's text format has them.

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <string>

namespace haptic::test {

/// The message that `text` says. Fails the test if it says none.
template <typename Message>
[[nodiscard]] Message from_text(const std::string& text) {
  Message message;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &message)) << text;
  return message;
}

/// Fails the test unless `message` is what `text` says, field by field.
template <typename Message>
void expect_text(const Message& message, const std::string& text) {
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(message, from_text<Message>(text)))
      << message.DebugString();
}

}  // namespace haptic::test
