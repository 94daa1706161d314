/// proto/README.md against the code: numbers, names and reasons, both ways.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>

#include "haptic/core/fault.hpp"
#include "haptic/core/projection/renderer_kind.hpp"
#include "haptic/core/safety/lifecycle.hpp"
#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"
#include "tests/proto/markdown.hpp"

namespace haptic::test {
namespace {

const std::filesystem::path kRoot = HAPTIC_SOURCE_DIR;

std::string readme() {
  return read_text(kRoot / "proto/README.md");
}

/// A table of numbers and reasons, as the README has it.
std::map<int, std::string> numbers(const std::string& first_header) {
  std::map<int, std::string> rows;
  for (const auto& row : markdown_table(readme(), first_header)) {
    rows.emplace(std::stoi(row.at(0)), unquoted(row.at(1)));
  }
  return rows;
}

TEST(ProtocolReadme, FaultsAreThoseOfTheCode) {
  std::map<int, std::string> code;
  for (int n = 0; n < 32; ++n) {
    const std::string reason(core::reason(static_cast<core::Fault>(n)));
    if (reason != "UNKNOWN_FAULT") code.emplace(n, reason);
  }
  ASSERT_GE(code.size(), 9u);
  EXPECT_EQ(numbers("fault"), code);
}

TEST(ProtocolReadme, LimitersAreThoseOfTheCode) {
  std::map<int, std::string> code;
  for (int n = 0; n < 32; ++n) {
    const std::string reason(core::reason(static_cast<core::Limiter>(n)));
    if (reason != "UNKNOWN_LIMITER") code.emplace(n, reason);
  }
  ASSERT_GE(code.size(), 5u);
  EXPECT_EQ(numbers("limiter"), code);
}

TEST(ProtocolReadme, StatesMatchCodeAndWire) {
  std::map<int, std::string> documented, code, wire;
  for (const auto& row : markdown_table(readme(), "state")) {
    documented.emplace(std::stoi(row.at(1)), unquoted(row.at(0)));
  }
  for (int n = 0; n < 32; ++n) {
    const std::string name(core::name(static_cast<core::LifecycleState>(n)));
    if (name != "UNKNOWN") code.emplace(n, name);
  }
  const std::string prefix = "DEVICE_STATE_NAME_";
  const auto* states = v1::DeviceStateName_descriptor();
  for (int i = 0; i < states->value_count(); ++i) {
    const std::string name = states->value(i)->name().substr(prefix.size());
    if (name != "UNSPECIFIED") wire.emplace(states->value(i)->number(), name);
  }
  EXPECT_EQ(documented, code);
  EXPECT_EQ(documented, wire);
}

TEST(ProtocolReadme, RenderersMatchCodeAndWire) {
  std::map<int, std::string> documented, wire;
  for (const auto& row : markdown_table(readme(), "renderer")) {
    documented.emplace(std::stoi(row.at(1)), unquoted(row.at(0)));
  }
  const auto* renderers = v1::Renderer_descriptor();
  for (int i = 0; i < renderers->value_count(); ++i) {
    const auto* value = renderers->value(i);
    if (value->number() == 0) continue;
    wire.emplace(value->number(), value->name());
    std::string core_name(core::name(static_cast<core::RendererKind>(value->number())));
    std::transform(core_name.begin(), core_name.end(), core_name.begin(), ::toupper);
    EXPECT_EQ("RENDERER_" + core_name, value->name());
  }
  EXPECT_EQ(documented, wire);
}

/// Upper-case literals of the sources below `folder`: reasons, and the words of events.
std::set<std::string> upper_case_literals(const std::filesystem::path& folder) {
  std::set<std::string> words;
  const std::regex literal("\"([A-Z][A-Z_]{2,})\"");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = read_text(entry.path());
    for (std::sregex_iterator it(text.begin(), text.end(), literal), end; it != end; ++it) {
      words.insert((*it)[1]);
    }
  }
  return words;
}

TEST(ProtocolReadme, DocumentsExactlyTheReasons) {
  std::set<std::string> code = upper_case_literals(kRoot / "server/session");
  code.merge(upper_case_literals(kRoot / "server/front"));
  code.merge(upper_case_literals(kRoot / "server/rpc"));
  ASSERT_GE(code.size(), 15u);
  std::set<std::string> documented;
  for (const auto& row : markdown_table(readme(), "reason")) {
    const std::string reason = unquoted(row.at(0));
    documented.insert(reason);
    EXPECT_TRUE(code.count(reason)) << reason << " is in proto/README.md, but no source says it";
  }
  // Words of events and of GetLinkStats have tables of their own.
  const std::set<std::string> of_events = {
      "FRESH",           "HOLD",          "FADE",           "LOST",
      "LEASE_EXPIRED",   "LEASE_GRANTED", "LEASE_DETACHED", "LEASE_RESUMED",
      "LEASE_PREEMPTED", "LEASE_ENDED",   "CLAMPED",        "OLD_SEQUENCE",
      "TRACKER_LOST",    "OLD_EPOCH",     "WRONG_SIZE",     "NOT_FINITE",
      "OUT_OF_BOUNDS",   "UNKNOWN_MODE",  "BAD_PLANE"};
  for (const std::string& word : code) {
    if (word == "UNKNOWN") continue;  // for a level that does not exist
    // Verdicts that refuse nothing, and a word for people.
    if (word == "ACCEPTED" || word == "BACKLOG" || word == "TLS") continue;
    if (of_events.count(word)) {
      EXPECT_NE(readme().find("`" + word), std::string::npos) << word;
    } else {
      EXPECT_TRUE(documented.count(word)) << word << " is missing in proto/README.md";
    }
  }
}

TEST(ProtocolReadme, EveryCallIsInTheTable) {
  const auto* service =
      v1::GetServerInfoRequest::descriptor()->file()->FindServiceByName("HapticService");
  ASSERT_NE(service, nullptr);
  std::set<std::string> wire, documented;
  for (int i = 0; i < service->method_count(); ++i) wire.insert(service->method(i)->name());
  for (const auto& row : markdown_table(readme(), "rpc")) documented.insert(unquoted(row.at(0)));
  EXPECT_EQ(documented, wire);
}

bool names(const std::string& text, const std::string& word) {
  return std::regex_search(text, std::regex("\\b" + word + "\\b"));
}

/// Fields of a message and of those inside it.
void expect_fields(const google::protobuf::Descriptor* message, const std::string& text) {
  for (int i = 0; i < message->field_count(); ++i) {
    const std::string& field = message->field(i)->name();
    EXPECT_TRUE(names(text, field)) << message->full_name() << "." << field;
  }
  for (int i = 0; i < message->nested_type_count(); ++i)
    expect_fields(message->nested_type(i), text);
}

TEST(ProtocolReadme, NamesEveryFieldOfTheWire) {
  const std::string text = readme();
  for (const auto* file :
       {v1::GetServerInfoRequest::descriptor()->file(), v1::ProxySample::descriptor()->file()}) {
    ASSERT_GT(file->message_type_count(), 10);
    for (int i = 0; i < file->message_type_count(); ++i) expect_fields(file->message_type(i), text);
  }
}

TEST(ProtocolReadme, ListsEveryKindOfEvent) {
  std::set<std::string> wire, documented;
  const auto* kinds = v1::Event::Kind_descriptor();
  for (int i = 0; i < kinds->value_count(); ++i) {
    if (kinds->value(i)->number() != 0) wire.insert(kinds->value(i)->name());
  }
  const std::regex kind("`(KIND_[A-Z_]+)`");
  for (const auto& row : markdown_table(readme(), "`kind`")) {
    const std::string& cell = row.at(0);
    for (std::sregex_iterator it(cell.begin(), cell.end(), kind), end; it != end; ++it)
      documented.insert((*it)[1]);
  }
  EXPECT_EQ(documented, wire);
}

}  // namespace
}  // namespace haptic::test
