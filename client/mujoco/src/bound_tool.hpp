#pragma once
/// The bindings of a tool, found in its model: which bodies they move, and how a point of these
/// moves with the device's coordinates.

#include <cstddef>
#include <vector>

#include "haptic/mujoco/tool.hpp"
#include "vectors.hpp"

namespace haptic::mujoco {

/// One binding, found.
struct Place {
  Binding binding{};
  int id{0};    ///< of joint, site or body
  int body{0};  ///< that it moves
  bool site{false};
  bool turns{false};        ///< a hinge's angle
  std::vector<int> dofs{};  ///< that it moves itself, without those of its parents
  double mass{0.0};         ///< that its spring meets at least, kg, or kg m^2 of a hinge
  double inertia{0.0};      ///< of a pose, kg m^2

  /// b less a of a joint's coordinate; of an angle the short way round.
  [[nodiscard]] double apart(double a, double b) const;
};

class BoundTool {
 public:
  /// Makes what Tool::Tool() makes, but changes nothing. `data`: after mj_forward.
  BoundTool(const mjModel& model, mjData& data, const std::vector<Binding>& bindings,
            const ToolOptions& options);

  [[nodiscard]] const std::vector<Place>& places() const noexcept { return places_; }
  /// One beyond the last coordinate that is bound.
  [[nodiscard]] std::size_t coordinates() const noexcept { return coordinates_; }
  [[nodiscard]] bool moves(int body) const { return moves_[static_cast<std::size_t>(body)]; }
  /// True if each pose's quaternion in x is one: not so short, 1e-3, or long that it is none.
  [[nodiscard]] bool has_turns(const std::vector<double>& x) const;
  /// DoFs below a bound body: those of bindings, and those that are the tool's own.
  [[nodiscard]] bool owns_dof(int dof) const { return owns_[static_cast<std::size_t>(dof)]; }
  /// Those, and the DoFs that carry a point or pose: its spring pulls them too.
  [[nodiscard]] bool pulls_dof(int dof) const { return pulls_[static_cast<std::size_t>(dof)]; }

  /// Writes the bound coordinates into x, angles and quaternions as near to what x holds as they
  /// can be said. Needs mj_kinematics.
  void read(const mjData& data, std::vector<double>& x) const;
  /// A point of `body`, which is the tool's, in the world; needs mj_kinematics, mj_comPos. With
  /// second derivatives if one pose alone or only joints move it, of at most 8 coordinates.
  [[nodiscard]] client::PointMap point_on(const mjData& data, int body, const Vector3& position,
                                          const std::vector<double>& x) const;
  /// Sum of (n . J)^2 / stiffness over joints with a spring between the binding and this point: how
  /// far a force of 1 N along n bends the tool itself, m/N.
  [[nodiscard]] double give(const mjData& data, int body, const Vector3& position,
                            const Vector3& normal) const;

 private:
  /// The joints that move a body, from it to the base.
  struct Path {
    std::vector<const Place*> joints{};
    const Place* frame{nullptr};  ///< a point or pose
    std::vector<int> soft{};      ///< joints of the tool's own that have a spring
  };
  [[nodiscard]] Path path(int body) const;
  void find(mjData& data, const Binding& binding);
  void refuse_stiff(const Place& place, const ToolOptions& options) const;

  const mjModel* model_;
  std::vector<Place> places_{};
  std::vector<int> place_of_joint_{}, frame_of_body_{};  ///< -1: none
  std::vector<char> moves_{}, owns_{}, pulls_{};
  std::size_t coordinates_{0};
};

/// The coordinates that a binding takes.
[[nodiscard]] std::size_t count_of(Binding::Kind kind) noexcept;
/// Position and turn of a site or body, in the world.
[[nodiscard]] Vector3 position_of(const mjData& data, const Place& place);
void quaternion_of(const mjData& data, const Place& place, mjtNum quaternion[4]);

}  // namespace haptic::mujoco
