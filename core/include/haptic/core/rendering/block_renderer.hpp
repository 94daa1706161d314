#pragma once
/// A renderer for every independent block of a map (the fingers of a hand), behind the call of one:
/// each block is projected by itself, and under Eq. (6) only when its part of the proxy changes
/// (core/METHOD.md#model-only-what-a-scene-needs). A map without blocks counts as one block, and so
/// does a map whose metric W_x weighs coordinates of different blocks together.
///
/// A block with dx = 0 is idle: its own pose is the answer, and it needs neither J nor a solve.
/// Eq. (6) needs J in no block and keeps its solution until the proxy changes.

#include <optional>
#include <vector>

#include "haptic/core/rendering/block_map.hpp"
#include "haptic/core/rendering/renderer.hpp"

namespace haptic::core {

class BlockRenderer {
 public:
  /// The model is copied; its kinematics must outlive the renderer.
  BlockRenderer(RendererKind kind, const ProjectionModel& model);
  /// Another renderer from here on, without memory of this one. Never allocates.
  void change(RendererKind kind) noexcept;

  [[nodiscard]] RendererKind kind() const noexcept { return kind_; }
  /// See Renderer::project. Several blocks have the worst status and condition, and the residual of
  /// all; the baselines' virtual stiffness is each block's own. An idle block is exact, with
  /// condition 0.
  void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
               bool proxy_changed, Projection& out) noexcept;
  /// The blocks whose J project() reads if dx is not 0 in the blocks `displaced`.
  [[nodiscard]] BlockSet reads_J(BlockSet displaced) const noexcept;
  /// Upper bound of displayed stiffness over Z_q per actuated DoF (n_a, >= 1) at this pose with the
  /// proxy held; the energy tank's spring is that much stiffer (core/METHOD.md#energy-tank). Eq.
  /// (6) and (8) display Z_q: 1. Eq. (1) displays J_a^T Z_x J_a, Eq. (2), and Eq. (4) at most that.
  /// With one scale of Z_x for all poses this may be several times Z_q, and a tank that booked Z_q
  /// would charge more energy than the user put in. A block with several actuators uses the trace
  /// of Z_q^{-1} J_a^T Z_x J_a for its largest eigenvalue. Idle blocks: 1. Never allocates.
  void displayed_bound(const Probe& probe, const VecX& dx, const VecA& stiffness,
                       VecA& ratio) const noexcept;
  /// Widens what ForceError knows (n_a) to how far the force may be off by this renderer: the rule
  /// per contact also depends on the contacts. The other arguments: of the last project(); dx = 0
  /// if there was none in this tick. False: nothing is known. Never allocates.
  [[nodiscard]] bool widen(const Probe& probe, const VecX& dx, const VecA& stiffness,
                           const ProxyError& error, VecA& force) noexcept;
  /// A contact ended.
  void release() noexcept;
  /// Forgets warm starts and cached solutions.
  void reset() noexcept;

 private:
  struct Block {
    Block(RendererKind kind, const ProjectionModel& of_block, const MapBlock& in_map);
    void project(const Probe& probe, const VecX& x, const VecX& dx, const VecA& stiffness,
                 bool proxy_changed) noexcept;
    [[nodiscard]] bool displaced(const VecX& all_dx) const noexcept;

    ProjectionModel model;
    Renderer renderer;
    MapBlock at;
    int n_q, n_a, n_x;
    bool seen{false};  ///< `x` is the proxy of the last call
    bool held{false};  ///< `out` answers for `x`, whatever q is: Eq. (6) without a prior
    VecQ q{};
    VecX x_probe{}, x{}, dx{};
    MatXQ J{};
    VecA stiffness{};
    Projection out{};
  };

  RendererKind kind_;
  ProjectionModel model_;
  bool idle_possible_{true};         ///< no prior, which pulls even if dx = 0
  std::optional<Renderer> whole_{};  ///< of a map without blocks
  std::vector<Block> blocks_{};      ///< else one per block
};

}  // namespace haptic::core
