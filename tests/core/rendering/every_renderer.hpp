#pragma once
/// Every renderer of the paper, for tests of what all of them share, and what they are asked with.

#include <gtest/gtest.h>

#include <utility>

#include "haptic/core/rendering/renderer.hpp"

namespace haptic::core {

inline constexpr RendererKind kEveryRenderer[] = {RendererKind::kStandard, RendererKind::kNullSpace,
                                                  RendererKind::kSubspaceLinear,
                                                  RendererKind::kSubspaceExact};

/// A device at q and a proxy x.
struct Instant {
  Instant(const Kinematics& map, VecQ at, VecX proxy) : q(std::move(at)), x(std::move(proxy)) {
    EXPECT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
    map.space().difference(x, x_probe, dx);
  }
  [[nodiscard]] Probe probe(const ContactView& contacts = {}) const {
    return {q, x_probe, J, contacts};
  }
  VecQ q{};
  VecX x{}, x_probe{}, dx{};
  MatXQ J{};
};

/// Answer of anything that projects as a Renderer does. `changed`: the proxy is another one.
template <typename AnyRenderer>
Projection projected(AnyRenderer& renderer, const Instant& at, const VecA& Z_q, bool changed = true,
                     const ContactView& contacts = {}) {
  Projection out;
  renderer.project(at.probe(contacts), at.x, at.dx, Z_q, changed, out);
  return out;
}

/// tau_a = Z_q S (q* - q).
inline VecA spring_force(const DofLayout& layout, const Projection& out, const VecQ& q,
                         const VecA& Z_q) {
  return Z_q.cwiseProduct(layout.select(out.q_star - q));
}

/// The same of a renderer that is asked for the first time.
inline VecA first_force(RendererKind kind, const ProjectionModel& model, const Instant& at,
                        const VecA& Z_q) {
  Renderer renderer(kind, model);
  return spring_force(model.layout(), projected(renderer, at, Z_q), at.q, Z_q);
}

}  // namespace haptic::core
