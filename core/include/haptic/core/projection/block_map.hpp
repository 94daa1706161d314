#pragma once
/// f and J of the device at one tick, as far as they are asked for
/// (core/METHOD.md#model-only-what-a-scene-needs): block by block
/// where the map falls into blocks (the fingers of a hand). A finger that nothing can hold in this
/// tick is left out; one at rest is not evaluated again; one that nothing does hold is asked for f
/// alone, without J. What is evaluated is the same to the bit as by Kinematics::evaluate of the
/// whole map.

#include <vector>

#include "haptic/core/model/block_set.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/plane_set.hpp"

namespace haptic::core {

class BlockMap {
 public:
  /// `kinematics` must outlive this.
  explicit BlockMap(const Kinematics& kinematics);

  /// x_probe() = f(q), q: n_q, of all blocks but those of `left_out`, whose f is not asked for.
  /// False where f has no value in a block that is not left out: its x_probe() stays as it was, the
  /// other blocks' is of q all the same, and J() means nothing. Never allocates.
  bool move_to(const VecQ& q, BlockSet left_out = 0) noexcept;
  /// After a move_to() that was true: J() of the blocks of `needed` is dx_probe/dq at its q, the
  /// other blocks are left as they are. What was needed in one tick move_to() brings along in the
  /// next, f and J in one evaluation. Never allocates.
  void differentiate(BlockSet needed) noexcept;

  [[nodiscard]] const VecX& x_probe() const noexcept { return x_probe_; }  ///< n_x; 0 before f
  /// The blocks of which x_probe() may be of any older q: left out by the last move_to(), or left
  /// out before and without f at every q since that was asked for. Finite there.
  [[nodiscard]] BlockSet unprobed() const noexcept { return unprobed_; }
  [[nodiscard]] const MatXQ& J() const noexcept { return J_; }  ///< n_x by n_q; 0 between blocks
  [[nodiscard]] BlockSet all() const noexcept { return all_; }
  /// The blocks in which dx (n_x) is not 0 throughout.
  [[nodiscard]] BlockSet displaced(const VecX& dx) const noexcept;
  /// The blocks that such planes (normals n_x by n) can hold: all but those in whose coordinates
  /// every normal is exactly 0.
  [[nodiscard]] BlockSet reached(const PlaneSet& planes) const noexcept;
  /// Writes the DoFs of `blocks` in `from` (n_q) into `to` (n_q).
  void copy_q(BlockSet blocks, const VecQ& from, VecQ& to) const noexcept;
  /// Writes `value` into the coordinates of `blocks` in x (n_x).
  void fill(BlockSet blocks, double value, VecX& x) const noexcept;

 private:
  struct Part {
    MapBlock at{};
    int n_q{0}, n_x{0};
    VecQ q{};            ///< where f was last asked for
    VecX x{};            ///< f(q) where it `closes`, else of the last q that did
    bool known{false};   ///< q is set
    bool closes{false};  ///< f has a value at q
    bool has_J{false};   ///< the block in J_ is of q
    bool wants_J{false};
  };
  void evaluate(Part& part) noexcept;

  std::vector<Part> parts_{};
  BlockSet all_{0};
  BlockSet unprobed_{0};
  VecX x_probe_{};
  MatXQ J_{};
  MatXQ block_{};  ///< J of one part
};

}  // namespace haptic::core
