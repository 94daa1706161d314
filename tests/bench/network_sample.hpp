#pragma once
/// The sample that the measurements of the datagram path send: the finger's, as publish() makes it.

#include "haptic/v1/session.pb.h"
#include "tests/bench/product.hpp"

namespace haptic::bench {

inline void fill(v1::ProxySample& sample, std::uint64_t seq) {
  sample.Clear();
  sample.set_seq(seq);
  sample.set_mode(v1::PROXY_MODE_HELD);
  sample.set_source_time_ns(now_ns());
  sample.set_device_seq_used(1'000'000 + seq);
  sample.set_hold_us(4000);
  sample.add_position(0.4);
  sample.add_position(0.5);
}

}  // namespace haptic::bench
