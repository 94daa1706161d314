#pragma once
/// How the object of a contact moves when the tool pushes it.

#include <optional>
#include <set>
#include <vector>

#include "bound_tool.hpp"
#include "skyline.hpp"

namespace haptic::mujoco {

/// The object of a contact that it can give way to.
struct PushedObject {
  client::Contact* told{nullptr};  ///< has the object's law
  int root{0};                     ///< the topmost of the bodies that move with it
  double force{0.0};               ///< of the contact, N
  // Per DoF that counts: how far the surface recedes, and u.
  std::vector<double> recedes{}, motion{};
  double give{0.0};  ///< J H^-1 J^T
};

/// All that is not the tool: bodies with their joints' springs and dampers, and MuJoCo's other
/// constraints (a floor, friction that sticks, joint limits). Each row of these has a force
/// (a_ref - a) / R: a spring, a damper and a mass 1 / R (contact_spring.hpp). Friction that slips
/// is a constant force. What the tool itself touches the server knows by its own contacts.
///
/// An object has one law per contact, so one way to give in: u, the motion of all joints by which
/// its surface recedes by 1 under a push that lasts 50 ms, the time for which the law must hold.
/// With H = M + h D + h^2 K over joints and rows and J the surface's way, u = H^-1 J^T / (J H^-1
/// J^T). Mass, damping and stiffness are those of u, the load is u^T times all forces but this
/// contact's and but what the damping and the rows' masses take. So a box between finger and ball
/// has the ball's stiffness, and one that slides is not stiff because it cannot turn into the
/// floor.
///
/// Only what is touched counts, and what rows connect with it: a pile costs nothing until one of it
/// is touched, and a box alone costs as if it were alone.
///
/// Contacts on the same body share it: the directions e_i are those of the u_i in the metric H, so
/// e_i . e_j = J_i H^-1 J_j^T / sqrt(J_i H^-1 J_i^T J_j H^-1 J_j^T), and no load holds the force of
/// another of them.
class Surroundings {
 public:
  explicit Surroundings(const BoundTool& tool) : tool_(&tool) {}

  /// Reads the contacts as the last mj_forward or mj_step found them. `rate`: qvel as it began, nv.
  /// `bodies`: those that object() will be asked for.
  void look(const mjModel& model, mjData& data, const std::vector<mjtNum>& rate,
            const std::set<int>& bodies);
  /// DoFs that count: those of the bodies, and those that rows connect with them.
  [[nodiscard]] std::size_t dofs() const noexcept { return dofs_.size(); }
  /// Tells a contact with `body` at `position` the law along its normal: mass, damping, stiffness
  /// to ground, load and velocity (proto/README.md, Objects that are pushed). `force`: of it, N.
  /// Empty: the body cannot move.
  [[nodiscard]] std::optional<PushedObject> object(const mjModel& model, const mjData& data,
                                                   int body, const Vector3& position, double force,
                                                   client::Contact& told) const;
  /// Takes all objects of a step. Tells contacts that push one body so: object, object_direction.
  static void share(const std::vector<PushedObject>& objects);

 private:
  struct Part {
    std::size_t i{0};  ///< in dofs_
    double value{0.0};
  };
  struct Row {
    std::vector<Part> way{};  ///< J
    double mass{0.0}, damping{0.0}, stiffness{0.0};
    double taken{0.0};  ///< by damping and mass now, N
  };
  struct Mass {  ///< an entry of M that is not 0
    std::size_t i{0}, k{0};
    double value{0.0};
  };
  /// True if a row is a spring now: it pushes, and does not slip. Its force says so, because MuJoCo
  /// 3 leaves efc_state as it was where it solves islands.
  [[nodiscard]] bool counts(const mjModel& model, const mjData& data, int row) const;
  void find_dofs(const mjModel& model, const mjData& data, const std::set<int>& touched);
  void find_masses(const mjModel& model, mjData& data);
  void look_at_row(const mjModel& model, const mjData& data, int index);

  const BoundTool* tool_;
  std::vector<std::size_t> dofs_{};   ///< that count, tree by tree; none is the tool's
  std::vector<std::size_t> trees_{};  ///< where each tree begins in dofs_, and the end
  std::vector<std::size_t> place_{};  ///< of each DoF in dofs_
  std::vector<Row> rows_{};
  std::vector<Mass> M_{};
  Skyline H_{};
  std::vector<double> push_{};  ///< all forces on the DoFs, and what their dampers take
  std::vector<mjtNum> rate_{};
};

}  // namespace haptic::mujoco
