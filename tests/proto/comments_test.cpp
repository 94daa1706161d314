/// Every field, value and call of the protocol is explained: by a comment in its .proto, or by name
/// in proto/README.md. The generated code keeps no comments, so protoc's descriptors are read.

#include <google/protobuf/descriptor.pb.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/proto/markdown.hpp"

namespace haptic::test {
namespace {

namespace pb = google::protobuf;
using Location = pb::SourceCodeInfo::Location;

/// The field, value or call at `location` of `file`; null if there is none.
const pb::Message* declaration(const pb::FileDescriptorProto& file, const Location& location) {
  if (location.path_size() % 2 != 0) return nullptr;  // within a declaration
  const pb::Message* at = &file;
  for (int i = 0; i < location.path_size(); i += 2) {
    const pb::FieldDescriptor* part = at->GetDescriptor()->FindFieldByNumber(location.path(i));
    if (!part->is_repeated() || part->message_type() == nullptr) return nullptr;
    at = &at->GetReflection()->GetRepeatedMessage(*at, part, location.path(i + 1));
  }
  for (const pb::Descriptor* type :
       {pb::FieldDescriptorProto::descriptor(), pb::EnumValueDescriptorProto::descriptor(),
        pb::MethodDescriptorProto::descriptor()}) {
    if (at->GetDescriptor() == type) return at;
  }
  return nullptr;
}

/// True if the README names a field or value. States stand there without their prefix,
/// and 0 of an enum, which means "not said", needs no word.
bool in_readme(const std::string& name) {
  static const std::string text = read_text(HAPTIC_SOURCE_DIR "/proto/README.md");
  const std::string prefix = "DEVICE_STATE_NAME_";
  const std::string documented = name.starts_with(prefix) ? name.substr(prefix.size()) : name;
  return name.ends_with("_UNSPECIFIED") || text.find("`" + documented + "`") != std::string::npos;
}

TEST(ProtoComments, ExplainEveryDeclaration) {
  pb::FileDescriptorSet described;
  std::ifstream in(HAPTIC_DESCRIBED_PROTOS, std::ios::binary);
  ASSERT_TRUE(described.ParseFromIstream(&in));
  ASSERT_EQ(described.file_size(), 4);
  for (const pb::FileDescriptorProto& file : described.file()) {
    int found = 0;
    for (const Location& location : file.source_code_info().location()) {
      const pb::Message* const declared = declaration(file, location);
      if (declared == nullptr) continue;
      ++found;
      if (location.has_leading_comments() || location.has_trailing_comments()) continue;
      const auto* name = declared->GetDescriptor()->FindFieldByName("name");
      const std::string said = declared->GetReflection()->GetString(*declared, name);
      const bool call = declared->GetDescriptor() == pb::MethodDescriptorProto::descriptor();
      EXPECT_TRUE(!call && in_readme(said))
          << file.name() << ":" << location.span(0) + 1 << ": " << said
          << " has no comment and is not in proto/README.md";
    }
    EXPECT_GT(found, 10) << file.name();
  }
}

}  // namespace
}  // namespace haptic::test
