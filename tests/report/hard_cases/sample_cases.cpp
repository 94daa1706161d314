/// core/METHOD.md#half-turns and core/METHOD.md#bad-numbers: proxies at the edge of what a number
/// can say.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic/core/model/stylus.hpp"
#include "haptic/core/projection/renderer.hpp"
#include "server/ingress/ingress.hpp"
#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecQ;
using core::VecX;

/// dq of a renderer for the stylus' own pose turned by `angle` about `axis`; `sign`: of its
/// quaternion.
VecQ turned(core::RendererKind kind, const core::ProjectionModel& model, const VecQ& q,
            const Eigen::Vector3d& axis, double angle, double sign) {
  VecX x_probe, dx;
  MatXQ J;
  static_cast<void>(model.kinematics().evaluate(q, x_probe, J));
  VecX x = x_probe;
  const Eigen::Quaterniond now(Eigen::Vector4d(x_probe.tail(4)));
  x.tail(4) = sign * (Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)) * now).coeffs();
  model.kinematics().space().difference(x, x_probe, dx);
  core::Projection out;
  core::Renderer(kind, model).project({q, x_probe, J}, x, dx, VecA::Ones(3), true, out);
  return out.q_star - q;
}

void rotations_by_pi(Outcomes& out) {
  const auto stylus = core::make_stylus({});
  core::ProjectionSettings settings;
  VecX scales(7);
  scales << VecX::Constant(3, 5e-3), VecX::Constant(4, 0.05);  // core/METHOD.md#metric-and-limits:
                                                               // m, half radians
  settings.metric = core::TaskMetric::from_scales(scales);
  const core::ProjectionModel model(*stylus, settings);
  const VecQ q = (VecQ(6) << 0.2, 0.5, -1.2, 0.1, 0.3, -0.4).finished();
  const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitX(), Eigen::Vector3d(1, -2, 3).normalized()};
  bool finite = true;
  double jump = 0.0, small = 0.0;
  for (const core::RendererKind kind : kMethods) {
    for (const Eigen::Vector3d& axis : axes) {
      for (const double angle : {1.0, M_PI - 1e-9, M_PI}) {
        const VecQ plus = turned(kind, model, q, axis, angle, 1.0);
        const VecQ minus = turned(kind, model, q, axis, angle, -1.0);
        finite = finite && plus.allFinite() && minus.allFinite();
        // At pi itself both ways round are as short: which one is taken may depend on the sign.
        if (angle < M_PI) jump = std::max(jump, (plus - minus).cwiseAbs().maxCoeff());
      }
      const VecQ still = turned(kind, model, q, axis, 0.0, -1.0);
      small = std::max(small, still.cwiseAbs().maxCoeff());
    }
  }
  out.push_back({"20",
                 "rotation error pi - 1e-9, pi, sign flip of the quaternion, every renderer: "
                 "finite, no jump for the flip",
                 said("%s; flip: %.1e at 1 rad and pi - 1e-9, %.1e at rest",
                      finite ? "finite" : "not finite", jump, small),
                 finite && jump < 1e-9 && small < 1e-9});
}

void bad_numbers(Outcomes& out) {
  using namespace std::chrono_literals;
  core::Mailbox<core::ProxySnapshot> mailbox;
  server::Ingress ingress(mailbox, 2);
  ingress.begin_lease(1, 60.0, 100ms);
  core::TimePoint now{1h};
  std::uint64_t seq = 0;
  const auto send = [&](double x0, double x1) {
    const double position[] = {x0, x1};
    server::ProxyCandidate candidate;
    candidate.epoch = 1;
    candidate.seq = ++seq;
    candidate.mode = core::ProxyMode::kHeld;
    candidate.position = position;
    candidate.position_size = 2;
    now += 17ms;
    return ingress.accept(candidate, now);
  };
  const bool good = send(0.25, -0.5) == server::IngressVerdict::kAccepted;
  const core::TimePoint born = now;
  int refused = 0;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL}) {
    refused += send(bad, 0.0) == server::IngressVerdict::kNotFinite;
    refused += send(0.0, bad) == server::IngressVerdict::kNotFinite;
  }
  mailbox.take();
  const core::ProxySnapshot kept = mailbox.value();
  const bool kept_and_ageing = kept.x[0] == 0.25 && kept.x[1] == -0.5 && kept.born == born;
  const std::uint64_t counted = ingress.counters().not_finite;
  const bool taken = send(1e-310, -5e-324) == server::IngressVerdict::kAccepted;
  mailbox.take();
  const VecX& flushed = mailbox.value().x;
  const bool zero = taken && flushed[0] == 0.0 && flushed[1] == 0.0;
  out.push_back({"21",
                 "NaN, infinite: refused and counted, the last proxy kept and ageing; subnormals "
                 "become 0",
                 said("%d of 6 refused, %llu counted; the last one %s; subnormals %s", refused,
                      static_cast<unsigned long long>(counted), kept_and_ageing ? "kept" : "lost",
                      zero ? "0" : "kept"),
                 good && refused == 6 && counted == 6 && kept_and_ageing && zero});
}

}  // namespace

void sample_cases(Outcomes& out) {
  rotations_by_pi(out);
  bad_numbers(out);
}

}  // namespace haptic::report
