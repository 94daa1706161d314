#pragma once
/// The error of the proxy, as it is at the actuators (core/METHOD.md#error-bound): by the
/// renderer's own sensitivity, block by block. The rule per contact has that of Eq. (8) behind
/// it, from which BlockRenderer::widen() goes on. Not offered with a prior, and by Eq. (6) only for
/// a proxy that is exact.

#include <vector>

#include "haptic/core/contacts/contacts.hpp"
#include "haptic/core/contacts/proxy_error.hpp"
#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/projection_model.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"

namespace haptic::core {

class ForceError {
 public:
  struct Renders {
    RendererKind kind;
    const VecQ& q;          ///< where its J is taken: q*, Eq. (6), or q
    const VecA& stiffness;  ///< diag(Z_q), n_a
    const MatAA& Z_q;       ///< size 0: diagonal
    const MatXQ& J;         ///< at q, n_x by n_q, in the blocks `known`
    BlockSet known{0};
  };

  /// The model's kinematics must outlive this.
  explicit ForceError(const ProjectionModel& model);
  /// Writes how far Z_q S (q* - q) may be from that of the simulation's own proxy (n_a). False:
  /// nothing is known. Evaluates the map only if J is not known. Never allocates.
  [[nodiscard]] bool at(const Renders& renders, const Contacts& contacts, const ProxyError& error,
                        VecA& force) noexcept;

 private:
  struct Block {
    MapBlock at;
    ProjectionModel model;
    LeastSquares solver;
  };
  /// How far x may be off in this block, ||.||_W.
  [[nodiscard]] double distance(const Block& block, const Contacts& contacts,
                                const ProxyError& error) const noexcept;

  std::vector<Block> blocks_{};  ///< one per block, or the whole map
  int n_a_;
  bool prior_;
  VecQ q_{};
  VecX x_{}, along_{};
  MatXQ J_{};
};

}  // namespace haptic::core
