#include "server/owner/link/sample_intake.hpp"

#include <utility>

#include "server/base/steady_now.hpp"

namespace haptic::server {

SampleIntake::SampleIntake(Owner& owner, Publisher& publisher)
    : owner_(owner),
      publisher_(publisher),
      proxy_arrivals_(owner.devices().size()),
      pose_arrivals_(owner.devices().size()) {}

bool SampleIntake::take(FrontProcess& front) {
  int taken = 0;
  bool well = true;
  for (; front.samples && well && taken < kPerTurn; ++taken) {
    const Next next = look_at_next(front.samples.get());
    if (next.what == Received::kNothing) break;
    if (next.what == Received::kGone) {
      close_aside(std::move(front.samples));
      break;
    }
    well = next.what == Received::kMessage && take_one(front, next);
  }
  if (taken > 0) publisher_.ring();
  return well;
}

bool SampleIntake::take_one(FrontProcess& front, const Next& next) {
  const int socket = front.samples.get();
  switch (static_cast<SampleKind>(next.word)) {
    case SampleKind::kProxy:
      if (!take_sample(socket, next.bytes, sample_)) return false;
      judge(sample_, proxy_arrivals_);
      return true;
    case SampleKind::kPose: {
      PoseSample pose;
      if (!take_sample(socket, next.bytes, pose)) return false;
      judge(pose, pose_arrivals_);
      return true;
    }
    case SampleKind::kStopAhead: {
      StopAhead stop;
      if (!take_sample(socket, next.bytes, stop)) return false;
      make_harmless(stop);
      if (stop.device < owner_.devices().size()) front.stops[stop.device] = stop.why;
      return true;
    }
  }
  return false;
}

template <typename Sample>
void SampleIntake::judge(Sample& sample, std::vector<ArrivalOrder>& arrivals) {
  if (sample.device >= arrivals.size()) return;
  make_harmless(sample, arrivals[sample.device].in_order(sample.arrival, steady_now()));
  Carrier carrier = Carrier::kGrpc;
  if constexpr (requires { sample.carrier; }) carrier = sample.carrier;
  publisher_.judged({sample.ticket, sample.seq, carrier, owner_.accept(sample)});
}

}  // namespace haptic::server
