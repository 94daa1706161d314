/// Headers that a user includes stand alone: no gRPC, protobuf or Eigen, neither type nor header.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace {

TEST(PublicHeaders, IncludeNothingForeign) {
  const std::filesystem::path folder =
      std::filesystem::path(HAPTIC_SOURCE_DIR) / "client/include/haptic/client";
  int headers = 0, includes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    ++headers;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      for (const char* foreign : {"grpc::", "google::", "protobuf::", "Eigen::", "v1::"}) {
        EXPECT_EQ(line.find(foreign), std::string::npos) << entry.path() << ": " << line;
      }
      if (line.rfind("#include", 0) != 0) continue;
      ++includes;
      const bool own = line.rfind("#include \"haptic/client/", 0) == 0 ||
                       line == "#include \"haptic/wire/ports.hpp\"";
      // A standard header's name has neither folder nor suffix.
      const bool standard =
          line.rfind("#include <", 0) == 0 && line.find_first_of("/.") == std::string::npos;
      EXPECT_TRUE(own || standard) << entry.path() << ": " << line;
    }
  }
  EXPECT_GT(headers, 1);
  EXPECT_GT(includes, headers);
}

}  // namespace
