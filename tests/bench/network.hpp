#pragma once
/// The measurements of the network's path, each a few lines of CSV (haptic-bench-network).
/// `blocks`: number of alternating blocks; CONTRIBUTING.md#measuring asks for 20 or more.

namespace haptic::bench {

/// From the making of a sample to the mailbox by UDP, AEAD and protobuf included, against a bare
/// datagram of the same size.
void udp_one_way(int blocks);

/// The proxy's age when a tick uses it, from publish() on, behind the relay with 10 ms each way and
/// losses of 0, 1, 5 and 10 %: by UDP against gRPC.
void age_at_use(int blocks);

}  // namespace haptic::bench
