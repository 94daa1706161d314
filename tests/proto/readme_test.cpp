/// proto/README.md against the code: numbers, names and reasons, both ways.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>

#include "haptic/core/fault.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"
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

using Numbers = std::map<int, std::string>;

/// A table of the README: numbers in one column, names in another.
Numbers documented(const std::string& first_header, std::size_t number, std::size_t name) {
  Numbers rows;
  for (const auto& row : markdown_table(readme(), first_header)) {
    rows.emplace(std::stoi(row.at(number)), unquoted(row.at(name)));
  }
  return rows;
}

/// Every value that `name` has a word for.
template <typename Enum>
Numbers coded(std::string_view (*name)(Enum), const std::string& unknown) {
  Numbers found;
  for (int n = 0; n < 32; ++n) {
    const std::string word(name(static_cast<Enum>(n)));
    if (word != unknown) found.emplace(n, word);
  }
  return found;
}

/// The values of the wire but 0, names without `prefix`.
Numbers on_the_wire(const google::protobuf::EnumDescriptor& type, const std::string& prefix) {
  Numbers found;
  for (int i = 0; i < type.value_count(); ++i) {
    const auto* value = type.value(i);
    if (value->number() != 0) found.emplace(value->number(), value->name().substr(prefix.size()));
  }
  return found;
}

TEST(ProtocolReadme, BitsAreThoseOfTheCode) {
  const Numbers faults = documented("fault", 0, 1), limiters = documented("limiter", 0, 1);
  ASSERT_TRUE(faults.size() >= 9u && limiters.size() >= 5u);
  EXPECT_EQ(faults, coded<core::Fault>(core::reason, "UNKNOWN"));
  EXPECT_EQ(limiters, coded<core::Limiter>(core::reason, "UNKNOWN"));
}

TEST(ProtocolReadme, StatesMatchCodeAndWire) {
  const Numbers states = documented("state", 1, 0);
  EXPECT_EQ(states, coded<core::LifecycleState>(core::name, "UNKNOWN"));
  EXPECT_EQ(states, on_the_wire(*v1::DeviceStateName_descriptor(), "DEVICE_STATE_NAME_"));
}

TEST(ProtocolReadme, RenderersMatchCodeAndWire) {
  const Numbers renderers = documented("renderer", 1, 0);
  EXPECT_EQ(renderers, on_the_wire(*v1::Renderer_descriptor(), ""));
  for (const auto& [number, name] : renderers) {
    std::string core_name(core::name(static_cast<core::RendererKind>(number)));
    std::transform(core_name.begin(), core_name.end(), core_name.begin(), ::toupper);
    EXPECT_EQ("RENDERER_" + core_name, name);
  }
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
  std::set<std::string> code = upper_case_literals(kRoot / "server/owner/rights");
  code.merge(upper_case_literals(kRoot / "server/front/session"));
  code.merge(upper_case_literals(kRoot / "server/front/grpc"));
  code.merge(upper_case_literals(kRoot / "server/front/service"));
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
  std::set<std::string> wire, listed;
  for (const auto& [number, name] : on_the_wire(*v1::Event::Kind_descriptor(), "")) {
    wire.insert(name);
  }
  const std::regex kind("`(KIND_[A-Z_]+)`");
  for (const auto& row : markdown_table(readme(), "`kind`")) {
    const std::string& cell = row.at(0);
    for (std::sregex_iterator it(cell.begin(), cell.end(), kind), end; it != end; ++it)
      listed.insert((*it)[1]);
  }
  EXPECT_EQ(listed, wire);
}

}  // namespace
}  // namespace haptic::test
