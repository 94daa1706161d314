#pragma once
/// The bindings of a tool, found in its model: which bodies they move, themselves and by way of its
/// constraints, and how a point of these moves with the device's coordinates.

#include <cstddef>
#include <vector>

#include "coupled_dofs.hpp"
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
  /// Makes what Tool::Tool() makes, and changes nothing but the armature of followers. `data`:
  /// after mj_forward; its constraints are not the model's until the next. Until look() the tool is
  /// all that constraints may ever move.
  BoundTool(mjModel& model, mjData& data, const std::vector<Binding>& bindings,
            const ToolOptions& options);
  /// Finds what constraints move now. After mj_forward or mj_step.
  void look(const mjData& data);

  /// Without second joints of a coordinate, which are coupled().followers().
  [[nodiscard]] const std::vector<Place>& places() const noexcept { return places_; }
  [[nodiscard]] const CoupledDofs& coupled() const noexcept { return coupled_; }
  /// One beyond the last coordinate that is bound.
  [[nodiscard]] std::size_t coordinates() const noexcept { return coordinates_; }
  [[nodiscard]] bool moves(int body) const { return moves_[static_cast<std::size_t>(body)]; }
  /// True if each pose's quaternion in x is one: not so short, 1e-3, or long that it is none.
  [[nodiscard]] bool has_turns(const std::vector<double>& x) const;
  /// DoFs of bodies that it moves.
  [[nodiscard]] bool owns_dof(int dof) const { return owns_[static_cast<std::size_t>(dof)]; }
  [[nodiscard]] const std::vector<char>& owned() const noexcept { return owns_; }
  /// Those, also if they were so once, and the DoFs that carry a point or pose: its spring pulls
  /// them too.
  [[nodiscard]] bool pulls_dof(int dof) const { return pulls_[static_cast<std::size_t>(dof)]; }

  /// Writes the bound coordinates into x, angles and quaternions as near to what x holds as they
  /// can be said. Needs mj_kinematics.
  void read(const mjData& data, std::vector<double>& x) const;
  /// A point of `body`, which is the tool's, in the world; needs mj_kinematics, mj_comPos. With
  /// second derivatives if one pose alone or only joints move it, of at most 8 coordinates.
  [[nodiscard]] client::PointMap point_on(const mjData& data, int body, const Vector3& position,
                                          const std::vector<double>& x) const;
  /// How far a force of 1 N along n at this point bends the tool's own joints, m/N: their springs,
  /// and the rows that lead them.
  [[nodiscard]] double give(const mjData& data, int body, const Vector3& position,
                            const Vector3& normal) const;

 private:
  /// All that moves a body, from it to the base.
  struct Path {
    std::vector<int> dofs{};      ///< that move
    const Place* frame{nullptr};  ///< a point or pose
  };
  [[nodiscard]] Path path(int body) const;
  void find(mjData& data, const Binding& binding);
  void find_joint(Place& place);
  void find_frame(mjData& data, Place& place);
  void refuse_stiff(const Place& place, const ToolOptions& options) const;
  void follow(mjModel& model, const Place& place, double spring);
  void find_moved();
  /// J of a point of `body`, 3 x nv.
  [[nodiscard]] std::vector<mjtNum> jacobian(const mjData& data, int body,
                                             const Vector3& position) const;

  const mjModel* model_;
  std::vector<Place> places_{}, followers_{};
  std::vector<int> frame_of_body_{};  ///< -1: none
  std::vector<char> moves_{}, owns_{}, pulls_{};
  CoupledDofs coupled_;
  std::size_t coordinates_{0};
};

/// The coordinates that a binding takes.
[[nodiscard]] std::size_t count_of(Binding::Kind kind) noexcept;
/// Position and turn of a site or body, in the world.
[[nodiscard]] Vector3 position_of(const mjData& data, const Place& place);
void quaternion_of(const mjData& data, const Place& place, mjtNum quaternion[4]);

}  // namespace haptic::mujoco
