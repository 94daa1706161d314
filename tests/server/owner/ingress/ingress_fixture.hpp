#pragma once
/// An ingress of two coordinates with a lease of 60 Hz.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/owner/ingress/ingress.hpp"

namespace haptic::server {

using namespace std::chrono_literals;

class IngressTest : public testing::Test {
 protected:
  IngressTest() { ingress.begin_lease(1, 60.0, 100ms); }

  IngressVerdict send(std::vector<double> position, core::TimePoint at,
                      core::ProxyMode mode = core::ProxyMode::kHeld) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = at,
                       .mode = mode,
                       .position = {position.data(), position.size()}};
    return judge(sample);
  }
  IngressVerdict judge(const ProxySample& sample) {
    const Verdict verdict = ingress.accept(sample);
    why = verdict.why.str();
    return verdict.verdict;
  }
  const core::ProxySnapshot& newest() {
    mailbox.take();
    return mailbox.value();
  }

  core::Mailbox<core::ProxySnapshot> mailbox;
  Ingress ingress{mailbox, 2};
  std::uint32_t epoch{1};
  std::uint64_t seq{0};
  std::string why;
  core::TimePoint t0{1h};
};

}  // namespace haptic::server
