#pragma once
/// What GetLinkStats says of a session (private to server/rpc).

#include "haptic/v1/haptic_service.pb.h"
#include "server/front/link_watch.hpp"
#include "server/udp/udp_path.hpp"
#include "server/udp/udp_port.hpp"

namespace haptic::server {

/// The transports, the clock and the ages of `link`. `path`: the session's UDP path; null: it has
/// none. `holds_lease`: the ages are of its samples.
void report_link(const LinkWatch& link, const UdpPath* path, bool holds_lease, core::TimePoint now,
                 v1::SessionLink& message);

/// The port's datagrams that no session answers for.
void report_unassigned(const UdpPort& port, v1::GetLinkStatsResponse& response);

}  // namespace haptic::server
