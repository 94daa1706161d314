/// The test vectors of proto/README.md, Contacts.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <vector>

#include "haptic/core/contacts/plane_projection.hpp"
#include "tests/proto/markdown.hpp"

namespace haptic::test {
namespace {

std::vector<double> numbers_of(const std::string& cell) {
  std::istringstream in(cell);
  std::vector<double> values;
  for (double value = 0.0; in >> value;) values.push_back(value);
  return values;
}

core::VecX vector_of(const std::string& cell) {
  const std::vector<double> values = numbers_of(cell);
  return core::VecX::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

TEST(ContactVectors, MatchTheProjection) {
  const auto rows = markdown_table(
      read_text(std::filesystem::path(HAPTIC_SOURCE_DIR) / "proto/README.md"), "contact");
  ASSERT_EQ(rows.size(), 5u);
  const core::ConfigurationSpace space(std::vector<core::Coordinate>(2));
  for (const auto& row : rows) {
    core::PlaneSet set;
    set.normals = vector_of(row.at(1));
    set.offsets = vector_of(row.at(2));
    set.compliance = vector_of(row.at(3));
    set.velocity = vector_of(row.at(4));
    set.curvature = vector_of(row.at(5));
    set.curved[0] = set.curvature.size() > 0 ? 2 : 0;
    ASSERT_TRUE(set.fits(2)) << row.at(0);
    core::PlaneProjection projection(space);
    projection.set(set, vector_of(row.at(6)));
    core::VecX x;
    static_cast<void>(projection.project(vector_of(row.at(8)), x, vector_of(row.at(7))[0]));
    EXPECT_NEAR((x - vector_of(row.at(9))).norm(), 0.0, 1e-8) << row.at(0);
  }
}

TEST(ContactVectors, PushedObjectsMoveAlike) {
  const auto rows = markdown_table(
      read_text(std::filesystem::path(HAPTIC_SOURCE_DIR) / "proto/README.md"), "pushed");
  ASSERT_EQ(rows.size(), 3u);
  const core::ConfigurationSpace space(std::vector<core::Coordinate>(2));
  for (const auto& row : rows) {
    const auto number = [&row](std::size_t i) { return numbers_of(row.at(i)).at(0); };
    core::PlaneSet set;
    set.normals = core::VecX::Unit(2, 0);
    set.offsets = core::VecX::Zero(1);
    set.compliance = core::VecX::Ones(1);
    set.velocity = core::VecX::Constant(1, number(5));
    set.laws.resize(4, 1);
    set.laws << number(1), number(2), number(3), number(4);
    ASSERT_TRUE(set.fits(2)) << row.at(0);
    core::PlaneProjection projection(space);
    projection.set(set, core::VecX::Zero(2));
    core::VecX x;
    const int ticks = static_cast<int>(std::lround(number(6) / 1e-3));
    for (int tick = 0; tick <= ticks; ++tick) {
      static_cast<void>(projection.project(0.01 * core::VecX::Unit(2, 0), x, 0.0, 1e-3));
    }
    EXPECT_NEAR(x[0], number(7), 3e-6) << row.at(0);
  }
}

TEST(ContactVectors, SharedObjectsMoveAlike) {
  const auto rows = markdown_table(
      read_text(std::filesystem::path(HAPTIC_SOURCE_DIR) / "proto/README.md"), "shared");
  ASSERT_EQ(rows.size(), 3u);
  const core::ConfigurationSpace space(std::vector<core::Coordinate>(2));
  for (const auto& row : rows) {
    core::PlaneSet set;
    set.normals.resize(2, 2);
    set.normals << core::VecX::Unit(2, 0), vector_of(row.at(1));
    set.offsets = core::VecX::Zero(2);
    set.compliance = core::VecX::Ones(2);
    set.velocity = vector_of(row.at(7));
    set.laws.resize(4, 2);
    for (Eigen::Index law = 0; law < 4; ++law) {
      set.laws.row(law) = vector_of(row.at(3 + static_cast<std::size_t>(law))).transpose();
    }
    set.objects.setZero(Eigen::NoChange, 2);
    set.objects.row(0).setOnes();
    set.objects(1, 0) = 1.0;
    set.objects.col(1).segment<2>(1) = vector_of(row.at(2));
    ASSERT_TRUE(set.fits(2)) << row.at(0);
    core::PlaneProjection projection(space);
    projection.set(set, core::VecX::Zero(2));
    core::VecX x;
    const auto ticks = std::lround(numbers_of(row.at(9)).at(0) / 1e-3);
    for (int tick = 0; tick <= ticks; ++tick) {
      static_cast<void>(projection.project(vector_of(row.at(8)), x, 0.0, 1e-3));
    }
    EXPECT_NEAR((x - vector_of(row.at(10))).norm(), 0.0, 3e-6) << row.at(0);
  }
}

}  // namespace
}  // namespace haptic::test
