#pragma once
/// Answer of GetLinkStats for a session.

#include <optional>

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/session/link_watch.hpp"

namespace haptic::server {

/// The stream by `carrier`, the clock and the ages of `link`. `path_clock`: the client's clock as
/// the datagram path knows it. `holds_lease`: the ages are of its samples.
void report_link(const LinkWatch& link, Carrier carrier,
                 const std::optional<wire::ClockOffset::Estimate>& path_clock, bool holds_lease,
                 core::TimePoint now, v1::SessionLink& message);

// The parts that a datagram path reports itself.
void report_samples(const CarrierFigures& figures, v1::LinkDirection& up);
void add_rejected(const char* reason, std::uint64_t count,
                  google::protobuf::RepeatedPtrField<v1::Rejected>& list);
void set_round_trip(const wire::RoundTrip& round_trip, v1::LinkTransport& transport);

}  // namespace haptic::server
