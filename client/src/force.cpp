#include "force.hpp"

#include <string>
#include <utility>

#include "haptic/v1/field_options.pb.h"

namespace haptic::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kRetry{50};
/// After the server agreed, a state says ENGAGING before this is over.
constexpr milliseconds kAgreed{200};
/// A FAULT this soon after want() may be older than the ClearFault that the user sent before it.
constexpr milliseconds kFaultMayBeOld{250};

/// True if time and more samples can cure the refusal.
bool curable(const ClientError& refused) {
  v1::EngageWait wait{};
  return refused.reason() == ErrorReason::kTimeout ||
         refused.reason() == ErrorReason::kUnreachable ||
         v1::EngageWait_Parse("ENGAGE_WAIT_" + std::string(refused.server_reason()), &wait);
}

}  // namespace

void Force::want(TimePoint now) {
  wanted_ = true;
  refusal_.reset();
  asked_at_ = due_ = now;
}

void Force::release(bool take_back) {
  wanted_ = false;
  refusal_.reset();
  if (take_back && engage_ == Engage::kUnderWay) engage_ = Engage::kTakenBack;
}

void Force::give_up(const ClientError& why) {
  if (std::exchange(wanted_, false)) refusal_ = why;
}

void Force::fault_seen(TimePoint now) {
  if (now - asked_at_ > kFaultMayBeOld) {
    give_up({ErrorReason::kNotReady, "the device is in FAULT"});
  }
}

std::optional<Force::TimePoint> Force::due() const noexcept {
  if (!wanted_ || engage_ != Engage::kNone) return std::nullopt;
  return due_;
}

bool Force::answered(const std::optional<ClientError>& refused, bool same_session, TimePoint now) {
  due_ = now + kRetry;
  if (std::exchange(engage_, Engage::kNone) == Engage::kTakenBack) return !wanted_;
  if (!wanted_) return false;
  refusal_ = refused;
  if (!refused) {
    wanted_ = again_;
    due_ = now + kAgreed;
  } else if (same_session && !curable(*refused)) {
    // A lease that is over ends nothing: the next session asks again. Its event tells of a
    // preemption.
    wanted_ = next_lease_ && refused->server_reason() == "NOT_CONTROLLER";
  }
  return false;
}

}  // namespace haptic::client
