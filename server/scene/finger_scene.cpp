#include "server/scene/finger_scene.hpp"

#include "server/scene/field_reader.hpp"
#include "server/scene/kinematics_scene.hpp"

namespace haptic::server {
namespace {

core::FingerDimensions read_numbers(const FieldReader& reader) {
  core::FingerDimensions d;
  reader.numbers({
      {"proximal_phalanx_m", &d.proximal_phalanx, Allowed::kPositive},
      {"rail_origin_x_m", &d.rail_origin.x, Allowed::kFinite},
      {"rail_origin_y_m", &d.rail_origin.y, Allowed::kFinite},
      {"rail_angle_rad", &d.rail_angle, Allowed::kFinite},
      {"body_d_x_m", &d.body_d.x, Allowed::kFinite},
      {"body_d_y_m", &d.body_d.y, Allowed::kFinite},
      {"body_e_x_m", &d.body_e.x, Allowed::kFinite},
      {"body_e_y_m", &d.body_e.y, Allowed::kFinite},
      {"rod1_m", &d.rod1, Allowed::kPositive},
      {"rod2_m", &d.rod2, Allowed::kPositive},
      {"slider1_lower_m", &d.slider1_lower, Allowed::kPositive},
      {"slider1_upper_m", &d.slider1_upper, Allowed::kPositive},
      {"slider2_lower_m", &d.slider2_lower, Allowed::kPositive},
      {"slider2_upper_m", &d.slider2_upper, Allowed::kPositive},
      {"l_x_lower_m", &d.l_x_lower, Allowed::kFinite},
      {"l_x_upper_m", &d.l_x_upper, Allowed::kFinite},
      {"q_B_lower_rad", &d.q_B_lower, Allowed::kFinite},
      {"q_B_upper_rad", &d.q_B_upper, Allowed::kFinite},
  });
  return d;
}

void check_order(const FieldReader& reader, const core::FingerDimensions& d) {
  struct Range {
    const char* upper_name;
    double lower, upper;
  };
  for (const Range& range : {Range{"slider1_upper_m", d.slider1_lower, d.slider1_upper},
                             Range{"slider2_upper_m", d.slider2_lower, d.slider2_upper},
                             Range{"l_x_upper_m", d.l_x_lower, d.l_x_upper},
                             Range{"q_B_upper_rad", d.q_B_lower, d.q_B_upper}}) {
    if (range.upper <= range.lower) {
      reader.wrong(range.upper_name, decimal(range.upper),
                   "must be above its lower limit, " + decimal(range.lower));
    }
  }
}

}  // namespace

core::FingerDimensions read_dimensions(v1::FingerExoskeletonScene& message, const std::string& path,
                                       Problems& problems) {
  const FieldReader reader(message, path, problems);
  const core::FingerDimensions dimensions = read_numbers(reader);
  check_order(reader, dimensions);
  return dimensions;
}

SharedKinematics read_finger_exoskeleton(v1::FingerExoskeletonScene& message,
                                         const std::string& path, Problems& problems) {
  const std::size_t before = problems.count();
  const core::FingerDimensions dimensions = read_dimensions(message, path, problems);
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_finger_exoskeleton(dimensions); }, path, problems);
}

}  // namespace haptic::server
