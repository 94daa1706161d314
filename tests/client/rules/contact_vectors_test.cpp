/// The shared vectors of contacts, which every language must compute (make_contacts.py).

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "haptic/client/solve.hpp"
#include "tests/client/rules/expect_near.hpp"

namespace haptic::client {
namespace {

using nlohmann::json;

const json& vectors() {
  static const json all =
      json::parse(std::ifstream(HAPTIC_SOURCE_DIR "/tests/client/contacts.json"));
  return all;
}

PointMap point_of(const json& tool, const std::vector<double>& x) {
  const std::string kind = tool["kind"];
  const std::size_t first = tool["first"];
  if (kind == "itself") return point_itself(x, first);
  if (kind == "pose") return point_on_pose(x, tool["offset"], first);
  if (kind == "finger") {
    return point_on_finger(tool["lengths"], x, tool["phalanx"], tool["along"], tool["palmar"],
                           first);
  }
  std::vector<JointAxis> joints;
  for (const json& joint : tool["joints"]) {
    joints.push_back({joint["origin"], joint["axis"], joint["prismatic"]});
  }
  return point_on_joints(joints, tool["point"], first);
}

/// The normal, the gap and the curvature of the object where the point is.
void meet(const json& object, Contact& contact) {
  const std::string shape = object["shape"];
  const Vector3 centre = object["centre"], axis = object["axis"];
  const double radius = object["radius"];
  Vector3 away = contact.point.position;
  double along = 0.0;
  for (std::size_t i = 0; i < 3; ++i) along += (away[i] -= centre[i]) * axis[i];
  for (std::size_t i = 0; i < 3 && shape == "rod"; ++i) away[i] -= along * axis[i];
  const double length = std::hypot(away[0], away[1], away[2]);
  const double distance = radius > 0.0 ? length : -length;
  for (std::size_t i = 0; i < 3; ++i) {
    contact.normal[i] = shape == "wall" ? axis[i] : away[i] / distance;
  }
  contact.gap = shape == "wall" ? along : distance - radius;
  if (shape == "ball") contact.curvature = sphere_curvature(contact.normal, distance);
  if (shape == "rod") contact.curvature = cylinder_curvature(contact.normal, axis, distance);
}

Contact contact_of(const json& told, const std::vector<double>& x) {
  Contact c{.point = point_of(told["tool"], x)};
  meet(told["object"], c);
  if (told["stiffness"] != "rigid") c.stiffness = told["stiffness"];
  c.velocity = told["velocity"];
  c.id = told["id"];
  c.mass = told["mass"];
  c.damping = told["damping"];
  c.ground_stiffness = told["ground_stiffness"];
  c.load = told["load"];
  if (!told["uncertainty"].is_null()) c.uncertainty = told["uncertainty"].get<double>();
  c.object = told["on"];
  c.object_direction = told["direction"].get<std::vector<double>>();
  return c;
}

TEST(ContactVectors, PlanesAreTheShared) {
  for (const json& row : vectors()["planes"]) {
    SCOPED_TRACE(row["contact"].dump());
    const std::vector<double> x = row["x"];
    const Plane plane = contact_at(x, contact_of(row["contact"], x), row["coupling"]);
    const json& expected = row["plane"];
    expect_near(plane.normal, expected["normal"], 1e-15);
    expect_near(plane.curvature, expected["curvature"], 1e-13);
    expect_near(plane.object_direction, expected["object_direction"], 1e-15);
    expect_near({plane.offset, plane.compliance, plane.velocity, plane.mass, plane.damping,
                 plane.ground_stiffness, plane.load},
                {expected["offset"], expected["compliance"], expected["velocity"], expected["mass"],
                 expected["damping"], expected["ground_stiffness"], expected["load"]},
                1e-15);
    EXPECT_EQ(plane.uncertainty.has_value(), !expected["uncertainty"].is_null());
    EXPECT_EQ(plane.uncertainty.value_or(0.0),
              expected["uncertainty"].is_null() ? 0.0 : expected["uncertainty"].get<double>());
    EXPECT_EQ(plane.first_coordinate, expected["first_coordinate"]);
    EXPECT_EQ(plane.id, expected["id"]);
    EXPECT_EQ(plane.object, expected["object"]);
  }
}

TEST(ContactVectors, ProxiesAreTheShared) {
  for (const json& row : vectors()["solve"]) {
    SCOPED_TRACE(row["name"]);
    const auto at = [&row](const std::vector<double>& x) {
      std::vector<Contact> contacts;
      for (const json& told : row["contacts"]) contacts.push_back(contact_of(told, x));
      return contacts;
    };
    const Solution found = solve(at, row["x_probe"], row["coupling"],
                                 {.start = row["start"], .weights = row["weights"]});
    EXPECT_TRUE(found.converged);
    EXPECT_LE(found.iterations, 12);
    EXPECT_EQ(found.proxy().mode, Mode::kPlanes);
    expect_near(found.x, row["x"], 1e-10);
  }
}

TEST(ContactVectors, HorizonsAreTheShared) {
  const auto seconds = [](const json& value) {
    return std::chrono::nanoseconds(std::llround(1e9 * value.get<double>()));
  };
  for (const json& row : vectors()["horizon"]) {
    EXPECT_NEAR(
        contact_horizon(seconds(row["round_trip_s"]), seconds(row["period_s"]), row["v_max"]),
        row["metres"], 1e-15);
  }
}

}  // namespace
}  // namespace haptic::client
