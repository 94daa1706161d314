/// Every field, value and call of the protocol is explained: by a comment in its .proto, or by name
/// in proto/README.md. The generated code keeps no comments, so the text is read.

#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "haptic/v1/drawing.pb.h"
#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/scene.pb.h"
#include "haptic/v1/session.pb.h"
#include "tests/proto/markdown.hpp"

namespace haptic::test {
namespace {

namespace pb = google::protobuf;

struct Declaration {
  enum class Kind { kField, kValue, kCall } kind{Kind::kField};
  std::string name{};
  int line{0};
  bool commented{false};  ///< behind it, or on the line above
};

/// The declarations of a .proto file, one a line, as ours are written.
std::vector<Declaration> declarations(const std::string& text) {
  static const std::regex field(R"(^\s*(?:optional |repeated )?[\w.]+ (\w+) = \d+(?:;| \[|$)(.*))");
  static const std::regex value(R"(^\s*([A-Z][A-Z0-9_]+) = \d+;(.*)$)");
  static const std::regex call(R"(^\s*rpc (\w+)(.*)$)");
  std::vector<Declaration> found;
  bool comment_above = false;
  int number = 0;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::smatch match;
    const auto add = [&](Declaration::Kind kind) {
      const bool behind = match[2].str().find("//") != std::string::npos;
      found.push_back({kind, match[1], number, comment_above || behind});
    };
    if (std::regex_match(line, match, value)) {
      add(Declaration::Kind::kValue);
    } else if (std::regex_match(line, match, call)) {
      add(Declaration::Kind::kCall);
    } else if (std::regex_match(line, match, field)) {
      add(Declaration::Kind::kField);
    }
    const std::size_t first = line.find_first_not_of(' ');
    comment_above = first != std::string::npos && line.compare(first, 2, "//") == 0;
  }
  return found;
}

int fields_in(const pb::Descriptor& type) {
  int count = type.field_count();
  for (int i = 0; i < type.nested_type_count(); ++i) count += fields_in(*type.nested_type(i));
  return count;
}

int values_in(const pb::Descriptor& type) {
  int count = 0;
  for (int i = 0; i < type.enum_type_count(); ++i) count += type.enum_type(i)->value_count();
  return count;
}

/// How many declarations protobuf itself sees in the file.
int declared(const pb::FileDescriptor& file) {
  int count = 0;
  for (int i = 0; i < file.message_type_count(); ++i) {
    count += fields_in(*file.message_type(i)) + values_in(*file.message_type(i));
  }
  for (int i = 0; i < file.enum_type_count(); ++i) count += file.enum_type(i)->value_count();
  for (int i = 0; i < file.service_count(); ++i) count += file.service(i)->method_count();
  return count;
}

/// Names that need no word: 0 of an enum, which stands for "not said".
bool speaks_for_itself(const Declaration& declaration) {
  return declaration.kind == Declaration::Kind::kValue &&
         declaration.name.find("_UNSPECIFIED") != std::string::npos;
}

/// "DEVICE_STATE_NAME_ARMED" -> "ARMED": the README has the states under their own names.
std::string documented_name(const Declaration& declaration) {
  const std::string prefix = "DEVICE_STATE_NAME_";
  const bool state = declaration.name.rfind(prefix, 0) == 0;
  return state ? declaration.name.substr(prefix.size()) : declaration.name;
}

void expect_explained(const pb::FileDescriptor& file) {
  const std::string root = HAPTIC_SOURCE_DIR "/proto/";
  const std::string readme = read_text(root + "README.md");
  const std::vector<Declaration> found = declarations(read_text(root + file.name()));
  ASSERT_EQ(static_cast<int>(found.size()), declared(file)) << "the text was not read right";
  for (const Declaration& declaration : found) {
    if (declaration.commented || speaks_for_itself(declaration)) continue;
    const bool in_readme =
        declaration.kind != Declaration::Kind::kCall &&
        readme.find("`" + documented_name(declaration) + "`") != std::string::npos;
    EXPECT_TRUE(in_readme) << file.name() << ":" << declaration.line << ": " << declaration.name
                           << " has no comment and is not in proto/README.md";
  }
}

TEST(ProtoComments, ExplainEveryDeclaration) {
  for (const pb::Descriptor* of :
       {v1::ProxySample::descriptor(), v1::GetServerInfoRequest::descriptor(),
        v1::Drawing::descriptor(), v1::Scene::descriptor()}) {
    expect_explained(*of->file());
  }
}

TEST(ProtoComments, MissingOnesAreFound) {
  const auto found = declarations(
      "message M {\n  // above\n  int32 a = 1;\n  repeated double b = 2;  // behind\n"
      "  optional int64 c = 3;\n}\nenum E {\n  E_X = 1;\n}\n  rpc Call(A) returns (B);\n");
  ASSERT_EQ(found.size(), 5u);
  EXPECT_TRUE(found[0].commented);
  EXPECT_TRUE(found[1].commented);
  EXPECT_FALSE(found[2].commented);
  EXPECT_EQ(found[2].name, "c");
  EXPECT_FALSE(found[3].commented);
  EXPECT_EQ(found[4].kind, Declaration::Kind::kCall);
}

}  // namespace
}  // namespace haptic::test
