#pragma once
/// DoFs of a model that move with the bound joints, because its constraints say so.

#include <mujoco/mujoco.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "skyline.hpp"

namespace haptic::mujoco {

/// A second joint of a coordinate. A spring of the tool's keeps it where the first one, its leader,
/// says: both as one against the probe.
struct Follower {
  int joint{0}, dof{0}, leader{0};  ///< leader: a DoF
  int leader_qpos{0};
  double ratio{0.0}, offset{0.0};       ///< qpos = offset + ratio times the leader's
  double stiffness{0.0}, damping{0.0};  ///< N m/rad, N m s/rad
};

/// Rows A of equalities (mimic joints, closed chains, welds), and of tendons and joints that are at
/// their limit, connect bound DoFs b with others, u. Held still, these follow by
///
///   du/dx = -H^-1 A_u^T k A_b db/dx,  H = A_u^T k A_u + K,
///
/// with the rows' stiffness k, and K of the joints' springs. With rows much stiffer than springs
/// that is -A_u^+ A_b. What nothing holds is held by next to nothing of its mass.
class CoupledDofs {
 public:
  explicit CoupledDofs(const mjModel& model);
  /// DoF `dof` moves by `scale` per unit of a coordinate.
  void bind(int dof, std::size_t coordinate, double scale);
  /// `dof` is pulled by a point or pose: rows do not count there.
  void leave_out(int dof) { kinds_[static_cast<std::size_t>(dof)] = Kind::kLeftOut; }
  /// Its DoF, which was bound, is led by a row from now on.
  void follow(const Follower& follower);
  [[nodiscard]] const std::vector<Follower>& followers() const noexcept { return followers_; }

  /// Reads the rows of the last mj_forward or mj_step. Those of tendons and joints count if they
  /// push; `ever`: of tendons, if they leave little room, whether they push or not.
  void look(const mjModel& model, const mjData& data, std::size_t coordinates, bool ever = false);

  /// d qpos of a DoF / dx, of coordinate c.
  [[nodiscard]] double way(int dof, std::size_t c) const {
    return ways_[static_cast<std::size_t>(dof) * coordinates_ + c];
  }
  [[nodiscard]] bool bound(int dof) const {
    return kinds_[static_cast<std::size_t>(dof)] == Kind::kBound;
  }
  /// It has a way().
  [[nodiscard]] bool moves(int dof) const { return moves_[static_cast<std::size_t>(dof)] != 0; }
  /// Bindings, rows or springs say where it is.
  [[nodiscard]] bool firm(int dof) const { return firm_[static_cast<std::size_t>(dof)] != 0; }
  /// It moves, and rows alone say where it is: its own spring does not count.
  [[nodiscard]] bool led(int dof) const { return led_[static_cast<std::size_t>(dof)] != 0; }

  /// Adds to `applied`, nv, what takes weight and passive forces of DoFs that move off the rows,
  /// and so off the bound ones; of `owned` DoFs also while a tendon that leads them is slack.
  void take_off(const mjData& data, const std::vector<char>& owned, mjtNum* applied) const;
  /// v^T H^-1 v over the firm DoFs that are not bound: `v`: per DoF, nv.
  [[nodiscard]] double give(const std::vector<mjtNum>& v) const;

 private:
  enum class Kind : unsigned char { kOther, kBound, kLeftOut };
  struct Row {
    std::vector<std::pair<int, double>> parts{};  ///< by DoF
    double stiffness{0.0};
  };
  void find_rows(const mjModel& model, const mjData& data, bool ever);
  [[nodiscard]] bool counts(const mjModel& model, const mjData& data, int row, bool ever) const;
  void find_ways();
  void find_firm();

  std::vector<std::size_t> roots_{};  ///< of each DoF: the first one of its tree
  std::vector<double> masses_{}, springs_{};
  std::vector<Kind> kinds_;
  std::vector<std::pair<std::size_t, double>> bound_;  ///< coordinate and scale of each DoF
  std::vector<Follower> followers_{};
  std::vector<char> slack_;  ///< DoFs that some row leads, at times, if it is a tendon's

  std::size_t coordinates_{0};
  std::vector<Row> rows_{};
  std::vector<int> dofs_{};           ///< u
  std::vector<std::size_t> place_{};  ///< of each DoF in dofs_
  std::vector<double> ways_{};
  std::vector<char> moves_{}, firm_{}, led_{};
  Skyline H_{};
};

}  // namespace haptic::mujoco
