#include "server/front/session/sample_ledger.hpp"

namespace haptic::server {

void SampleLedger::book(std::uint64_t seq, const Verdict& verdict) {
  changed_ = true;
  if (verdict.used()) {
    const bool backlog = verdict.verdict == IngressVerdict::kBacklog;
    ack_.set_newest_seq(seq);
    ack_.set_accepted(ack_.accepted() + 1);
    ack_.set_conflated_backlog(ack_.conflated_backlog() + (backlog ? 1 : 0));
    return;
  }
  if (verdict.verdict <= IngressVerdict::kOldEpoch) {
    ack_.set_rejected_old(ack_.rejected_old() + 1);
  } else {
    ack_.set_rejected_invalid(ack_.rejected_invalid() + 1);
  }
  rejected_ = true;
  ack_.set_last_rejection(verdict.why.str());
}

void SampleLedger::look(core::TimePoint now) noexcept {
  now_ = now;
  const core::Duration since = now - told_;
  due_ = due_ || (changed_ && since >= kEvery) || (rejected_ && since >= kEveryRejected);
}

const v1::SampleAck& SampleLedger::tell() noexcept {
  changed_ = rejected_ = due_ = false;
  told_ = now_;
  return ack_;
}

}  // namespace haptic::server
