#pragma once
/// A pipeline in virtual time at 1 kHz: an armed device, the holder of a lease, and a client that
/// speaks in every tick. Its first sample is free: the probe comes from outside. Every tick is held
/// to two rules: it allocates nothing, and another pipeline answers the same bits to the input that
/// its record has and the same sample.

#include <gtest/gtest.h>

#include "haptic/core/tick/pipeline.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/identical.hpp"

namespace haptic::core::test {

class DrivenPipeline {
 public:
  explicit DrivenPipeline(const PipelineConfig& config) : pipeline(config), again_(config) {
    input.settings = config.scene;
    input.device.armed = true;
    input.command.tenure = proxy.tenure = 1;
    input.command.lease_held = true;
    proxy.mode = ProxyMode::kHeld;
  }
  virtual ~DrivenPipeline() = default;
  /// `sample`, `publish`: the device and the client give something new.
  const TickRecord& tick(bool sample = true, bool publish = true) {
    input.now += std::chrono::milliseconds(1);
    input.device.fresh = sample;
    if (sample) {
      ++input.device.sample.seq;
      input.device.sample.time = input.now;
    }
    if (publish) {
      if (proxy.gapless_samples++ == 0) proxy.gapless_since = input.now;
      ++proxy.seq;
      proxy.born = input.now;
      prepare();
    }
    const bool first = proxy.seq == 1 && proxy.mode == ProxyMode::kHeld;
    if (first) proxy.mode = ProxyMode::kFree;
    const haptic::test::AllocationGuard guard;
    record = pipeline.tick(input, proxy);
    EXPECT_EQ(guard.allocations() + guard.releases(), 0u);
    if (replays) {
      EXPECT_TRUE(identical(again_.tick(record.input, proxy), record)) << record.beat.tick;
    }
    if (first) proxy.mode = ProxyMode::kHeld;
    return record;
  }
  const TickRecord& run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
    return record;
  }
  /// ENGAGED with g = 1.
  const TickRecord& engage() {
    run(250);
    ++input.command.engage_id;
    tick();
    EXPECT_EQ(record.life.engage.verdict, EngageVerdict::kAccepted);
    run(205);
    EXPECT_EQ(record.life.state, LifecycleState::kEngaged);
    return record;
  }

  Pipeline pipeline;
  TickInput input{};
  ProxySnapshot proxy{};  ///< the client's newest sample
  TickRecord record{};    ///< of the last tick
  bool replays{true};

 protected:
  virtual void prepare() {}  ///< what else the client's next sample carries

 private:
  Pipeline again_;
};

}  // namespace haptic::core::test
