// Every field of a scene is shown in a shipped scene or in one of server/scenes/fragments.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "haptic/v1/calibration.pb.h"
#include "haptic/v1/scene.pb.h"
#include "tests/proto/markdown.hpp"
#include "tests/support/message_text.hpp"

namespace haptic::test {
namespace {

namespace fs = std::filesystem;
using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::vector<fs::path> scenes_and_fragments() {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(HAPTIC_SOURCE_DIR) / "server/scenes")) {
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  }
  return files;
}

bool is_calibration(const fs::path& file) {
  return file.stem().extension() == ".calibration";
}

/// The fields of `type` and of the messages in it, but for those of google.protobuf.
void collect(const Descriptor& type, std::set<const FieldDescriptor*>& fields) {
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    const bool fresh = fields.insert(field).second;
    const Descriptor* inner = field->message_type();
    if (fresh && inner != nullptr && inner->file()->package() == "haptic.v1") {
      collect(*inner, fields);
    }
  }
}

/// Takes away the fields that are set in `message`.
void strike(const Message& message, std::set<const FieldDescriptor*>& fields) {
  std::vector<const FieldDescriptor*> set;
  message.GetReflection()->ListFields(message, &set);
  for (const FieldDescriptor* field : set) {
    fields.erase(field);
    if (field->message_type() == nullptr) continue;
    const auto* reflection = message.GetReflection();
    if (!field->is_repeated()) strike(reflection->GetMessage(message, field), fields);
    for (int i = 0; field->is_repeated() && i < reflection->FieldSize(message, field); ++i) {
      strike(reflection->GetRepeatedMessage(message, field, i), fields);
    }
  }
}

TEST(SceneFeatures, EachFieldIsShownSomewhere) {
  std::set<const FieldDescriptor*> fields;
  collect(*v1::Scene::descriptor(), fields);
  collect(*v1::Calibration::descriptor(), fields);
  EXPECT_GT(fields.size(), 200u);
  for (const fs::path& file : scenes_and_fragments()) {
    if (is_calibration(file)) {
      strike(from_text<v1::Calibration>(read_text(file)), fields);
    } else {
      strike(from_text<v1::Scene>(read_text(file)), fields);
    }
  }
  for (const FieldDescriptor* field : fields) ADD_FAILURE() << field->full_name();
}

TEST(SceneFeatures, EachFileNamesItsProto) {
  for (const fs::path& file : scenes_and_fragments()) {
    const std::string header = is_calibration(file)
                                   ? "# proto-file: haptic/v1/calibration.proto\n"
                                     "# proto-message: haptic.v1.Calibration\n#\n# "
                                   : "# proto-file: haptic/v1/scene.proto\n"
                                     "# proto-message: haptic.v1.Scene\n#\n# ";
    EXPECT_EQ(read_text(file).substr(0, header.size()), header) << file;
  }
}

}  // namespace
}  // namespace haptic::test
