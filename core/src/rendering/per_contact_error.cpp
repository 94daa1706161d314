// Eq. (39) by the rule per contact (core/METHOD.md#error-bound).
#include <algorithm>
#include <cmath>

#include "haptic/core/contacts/contact_leverage.hpp"
#include "haptic/core/rendering/per_contact.hpp"

namespace haptic::core {

namespace {

/// Share that the contacts leave of a push by one actuator.
struct Share {
  double least{1.0}, most{1.0};
};

}  // namespace

bool PerContact::widen(const Probe& probe, const VecA& stiffness, const ProxyError& error,
                       VecA& force) noexcept {
  if (model_.prior() || model_.coupling()) return false;
  const DofLayout& layout = model_.layout();
  const int n_a = layout.n_a();
  VecA tau_8(n_a);
  for (int i = 0; i < n_a; ++i) tau_8[i] = stiffness[i] * solver_.dq()[layout.actuated(i)];
  const VecA most_wished = tau_8.cwiseAbs() + force;
  if (1.0 / solver_.condition() < damped_from(probe.contacts, stiffness, most_wished)) return false;
  double felt = 0.0, felt_off = 0.0;
  for (int i = 0; i < n_a && n_a > 1; ++i) felt_off += force[i] * solver_.felt(VecA::Unit(n_a, i));
  if (n_a > 1) felt = solver_.felt(tau_8);

  Share up, down;          // of tau > 0 and of tau < 0
  bool held_back = false;  // several actuators: there may be a condition that is broken
  const auto meet = [&](const Push& push) {
    const double off = error.depth.size() > 0 ? error.depth[push.contact] : 0.0;
    const double turn = error.turn.size() > 0 ? error.turn[push.contact] : 0.0;
    if (n_a > 1) {
      const double in = push.cosine * felt_off + turn * (felt + felt_off) - push.out.dot(tau_8);
      const double slack = slack_at(push.depth + off, band_, push.cosine + turn);
      const double allowed = slack * std::max(0.0, push.cosine - turn) * (felt - felt_off);
      held_back = held_back || in > allowed;
      return;
    }
    const bool beside = (error.beside >> push.contact & 1u) != 0;
    const auto narrow = [&](Share& share, double into) {
      if (into + turn <= 0.0) return;
      share.least = std::min(share.least, slack_at(push.depth + off, band_, into + turn));
      if (beside) return;
      const double nearest = std::max(0.0, into - turn);
      share.most = std::min(share.most, slack_at(push.depth - off, band_, nearest));
    };
    const double into = std::copysign(push.cosine, -push.out[0]);
    narrow(up, into);
    narrow(down, -into);
  };
  for (int k = 0; k < pushed_; ++k) meet(pushes_[static_cast<std::size_t>(k)]);
  for (int i = 0; i < error.depth.size(); ++i) {
    Push near;
    near.depth = probe.contacts.contacts->depth[i];
    if (near.depth > 0.0 || !(near.depth + error.depth[i] > 0.0)) continue;
    near.contact = i;
    out_ = -probe.contacts.contacts->into.col(i).segment(probe.contacts.first_x, model_.n_x());
    if ((out_.array() == 0.0).all()) continue;
    model_.metric().weigh(out_);
    near.out = solver_.also(model_.metric().weighed(probe.J, J_W_), out_);
    near.cosine = leverage(solver_, near.out);
    meet(near);
  }
  if (n_a > 1) {
    return !held_back && (most_wished.array() <= most(probe.contacts, stiffness).array()).all();
  }
  const double highest = tau_8[0] + force[0], lowest = tau_8[0] - force[0];
  force[0] = std::max(highest * (highest > 0.0 ? up.most : down.least) - tau_[0],
                      tau_[0] - lowest * (lowest > 0.0 ? up.least : down.most));
  return true;
}

}  // namespace haptic::core
