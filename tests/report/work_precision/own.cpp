#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/projection/block_renderer.hpp"
#include "haptic/core/projection/proxy_solver.hpp"
#include "tests/report/work_precision/method.hpp"

namespace haptic::report {
namespace {

using core::Kinematics;
using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;

/// What the methods with a Jacobian share.
class OnMap : public Method {
 public:
  OnMap(std::string name, const Kinematics& map)
      : Method(std::move(name)), map_(map), one_(VecA::Ones(map.layout().n_a())) {}
  void begin(const VecQ& q) override { q_star_ = q; }

 protected:
  /// f and J at q, and dx from there to x.
  bool look(const VecQ& q, const VecX& x) {
    if (map_.evaluate(q, at_, J_) != core::MapStatus::kOk) return false;
    map_.space().difference(x, at_, dx_);
    return true;
  }
  const Kinematics& map_;
  VecA one_;
  VecQ q_star_{};
  VecX at_{}, dx_{};
  MatXQ J_{};
};

template <typename Renderer>
class Linear final : public OnMap {
 public:
  Linear(std::string name, const Kinematics& map)
      : OnMap(std::move(name), map),
        renderer_(core::RendererKind::kSubspaceLinear, core::ProjectionModel(map)) {}
  const VecQ& solve(const VecQ& q, const VecX& x) override {
    if (look(q, x)) renderer_.project(core::Probe{q, at_, J_}, x, dx_, one_, true, out_);
    return out_.q_star;
  }

 private:
  Renderer renderer_;
  core::Projection out_{};
};

class GaussNewton final : public OnMap {
 public:
  GaussNewton(const Kinematics& map, int steps, bool warm)
      : OnMap("gn" + std::to_string(steps) + (warm ? "_warm" : "_cold"), map),
        steps_(steps),
        warm_(warm),
        solver_(map.space().n_x(), map.layout()) {}
  const VecQ& solve(const VecQ& q, const VecX& x) override {
    if (!warm_) q_star_ = q;
    for (int n = 0; n < steps_ && look(q_star_, x); ++n) {
      solver_.solve(J_, dx_, one_);
      q_star_ += solver_.dq();
    }
    return q_star_;
  }

 private:
  int steps_;
  bool warm_;
  core::LeastSquares solver_;
};

class Iterated final : public OnMap {
 public:
  explicit Iterated(const Kinematics& map)
      : OnMap("lm_warm", map), solver_(core::ProjectionModel(map)) {}
  const VecQ& solve(const VecQ&, const VecX& x) override {
    solver_.solve(x, q_star_, one_, out_);
    q_star_ = out_.q_star;
    return q_star_;
  }

 private:
  core::ProxySolver solver_;
  core::Projection out_{};
};

class ClosedForm final : public OnMap {
 public:
  explicit ClosedForm(const Kinematics& map) : OnMap("closed_form", map) {}
  const VecQ& solve(const VecQ&, const VecX& x) override {
    static_cast<void>(map_.inverse(x, q_star_));
    return q_star_;
  }
};

}  // namespace

Methods own_methods(const Kinematics& map) {
  Methods all;
  all.push_back(std::make_unique<Linear<core::Renderer>>("eq8", map));
  if (!map.blocks().empty()) {
    all.push_back(std::make_unique<Linear<core::BlockRenderer>>("eq8_blocks", map));
  }
  for (const bool warm : {false, true}) {
    for (int steps = 1; steps <= 4; ++steps) {
      all.push_back(std::make_unique<GaussNewton>(map, steps, warm));
    }
  }
  all.push_back(std::make_unique<Iterated>(map));
  VecQ q = VecQ::Zero(map.layout().n_q());
  if (map.inverse(VecX::Zero(map.space().n_x()), q) != core::InverseStatus::kNotOffered) {
    all.push_back(std::make_unique<ClosedForm>(map));
  }
  return all;
}

}  // namespace haptic::report
