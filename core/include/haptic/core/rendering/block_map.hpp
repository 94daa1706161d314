#pragma once
/// f of the device at one tick, and J as far as it is asked for
/// (core/METHOD.md#model-only-what-a-scene-needs): block by block if the map falls into blocks (the
/// fingers of a hand). A finger at rest is not evaluated again, and one that nothing displaces
/// costs f alone. The results are the same to the bit as Kinematics::evaluate of the whole map.

#include <vector>

#include "haptic/core/contacts/proxy_snapshot.hpp"
#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

class BlockMap {
 public:
  /// `kinematics` must outlive this.
  explicit BlockMap(const Kinematics& kinematics);

  /// x_probe() = f(q), q: n_q. Returns the blocks in which f has no value at q; their x_probe()
  /// stays as it was. Never allocates.
  [[nodiscard]] BlockSet move_to(const VecQ& q) noexcept;
  /// J() of the blocks of `needed`, which all have a value of f, is dx_probe/dq at the q of the
  /// last move_to(); the other blocks are left as they are. If a block's J was needed in this
  /// tick, the next move_to() computes f and J together. Never allocates.
  void differentiate(BlockSet needed) noexcept;

  /// n_x; before f 0, and quaternions 0, 0, 0, 1.
  [[nodiscard]] const VecX& x_probe() const noexcept { return x_probe_; }
  [[nodiscard]] const MatXQ& J() const noexcept { return J_; }  ///< n_x by n_q; 0 between blocks
  [[nodiscard]] BlockSet all() const noexcept { return all_; }
  /// The blocks in which dx (n_x) is not 0 throughout.
  [[nodiscard]] BlockSet displaced(const VecX& dx) const noexcept;
  /// The blocks that such planes (normals n_x by n) can hold: all but those in whose coordinates
  /// every normal is exactly 0.
  [[nodiscard]] BlockSet reached(const PlaneSet& planes) const noexcept;
  /// Writes the DoFs of `blocks` in `from` (n_q) into `to` (n_q).
  void copy_q(BlockSet blocks, const VecQ& from, VecQ& to) const noexcept;
  /// The same for coordinates, n_x.
  void copy_x(BlockSet blocks, const VecX& from, VecX& to) const noexcept;
  /// Writes 0 into the coordinates of `blocks` in x (n_x).
  void clear_x(BlockSet blocks, VecX& x) const noexcept;

 private:
  struct Block {
    MapBlock at{};
    int n_q{0}, n_x{0};
    VecQ q{};            ///< where f was last asked for
    VecX x{};            ///< f(q); if f has no value at q, the last value it had
    bool known{false};   ///< q is set
    bool closes{false};  ///< f has a value at q
    bool has_J{false};   ///< the block in J_ is of q
    bool wants_J{false};
  };
  void evaluate(Block& block) noexcept;

  std::vector<Block> blocks_{};
  BlockSet all_{0};
  VecX x_probe_{};
  MatXQ J_{};
  MatXQ block_J_{};  ///< J of one block
};

}  // namespace haptic::core
