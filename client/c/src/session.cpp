/// The functions of haptic.h that take a session.

#include "border.hpp"
#include "convert.hpp"

using namespace haptic::c;  // every definition here is one of haptic.h
namespace client = haptic::client;

namespace {

constexpr std::size_t kMostPlanes = 1024;  // haptic_publish_planes() says it

/// All of size planes->size, one after the other.
std::vector<client::Plane> read_planes(const haptic_plane* planes, std::size_t count,
                                       std::size_t coordinates) {
  if (count > kMostPlanes) {
    refuse("plane_count = " + std::to_string(count) + ", must be at most " +
           std::to_string(kMostPlanes));
  }
  std::vector<client::Plane> to;
  if (count == 0) return to;
  const std::size_t size = sized(planes, "planes")->size;
  to.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const char* const at = reinterpret_cast<const char*>(planes) + i * size;
    const auto* const plane = reinterpret_cast<const haptic_plane*>(at);
    if (plane->size != size) {
      refuse("planes[" + std::to_string(i) + "].size = " + std::to_string(plane->size) +
             ", must be that of planes[0] (" + std::to_string(size) + ")");
    }
    to.push_back(to_plane(read(plane, "planes"), coordinates));
  }
  return to;
}

}  // namespace

int haptic_close(haptic_session* session) {
  return guarded(nullptr, [&] { (*sessions().take(session))->close(); });
}

int haptic_device_of(haptic_session* session, haptic_device* device, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    write(to_struct<haptic_device>((*found)->device()), sized(device, "device"));
  });
}

int haptic_newest_state(haptic_session* session, haptic_state* state, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(state, "state");
    write(to_struct<haptic_state>((*found)->state()), state);
  });
}

int haptic_wait_for_state(haptic_session* session, uint32_t timeout_ms, haptic_state* state,
                          haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(state, "state");
    const std::chrono::milliseconds timeout(timeout_ms);
    write(to_struct<haptic_state>((*found)->wait_for_state(timeout)), state);
  });
}

int haptic_publish(haptic_session* session, const haptic_proxy* proxy, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    const haptic_proxy wanted = read(proxy, "proxy");
    client::Proxy made{.device_seq_used = wanted.device_seq_used,
                       .valid_for = std::chrono::microseconds(wanted.valid_for_us)};
    const std::size_t coordinates = found->coordinates();
    if (wanted.mode < HAPTIC_HELD || wanted.mode > HAPTIC_PLANES) {
      refuse("proxy->mode = " + std::to_string(wanted.mode) + ", must be 1 to 3");
    }
    made.mode = static_cast<client::Mode>(wanted.mode);
    if (wanted.mode != HAPTIC_FREE)
      made.position = to_position(wanted.x, wanted.count, coordinates);
    if (wanted.mode == HAPTIC_PLANES) {
      made.planes = read_planes(wanted.planes, wanted.plane_count, coordinates);
    }
    found->check_publisher(false);
    (*found)->publish(std::move(made));
  });
}

int haptic_publish_free(haptic_session* session, haptic_error* error) {
  haptic_proxy proxy{};
  proxy.size = sizeof proxy;
  proxy.mode = HAPTIC_FREE;
  return haptic_publish(session, &proxy, error);
}

int haptic_publish_held(haptic_session* session, const double* x, size_t count,
                        haptic_error* error) {
  haptic_proxy proxy{};
  proxy.size = sizeof proxy;
  proxy.mode = HAPTIC_HELD;
  proxy.x = x;
  proxy.count = count;
  return haptic_publish(session, &proxy, error);
}

int haptic_publish_planes(haptic_session* session, const double* x, size_t count,
                          const haptic_plane* planes, size_t plane_count, haptic_error* error) {
  haptic_proxy proxy{};
  proxy.size = sizeof proxy;
  proxy.mode = HAPTIC_PLANES;
  proxy.x = x;
  proxy.count = count;
  proxy.planes = planes;
  proxy.plane_count = plane_count;
  return haptic_publish(session, &proxy, error);
}

int haptic_publish_pose(haptic_session* session, const haptic_pose* pose, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    const haptic_pose wanted = read(pose, "pose");
    client::Pose made{.valid_for = std::chrono::microseconds(wanted.valid_for_us)};
    std::copy_n(wanted.position, made.position.size(), made.position.begin());
    std::copy_n(wanted.orientation, made.orientation.size(), made.orientation.begin());
    found->check_publisher(true);
    (*found)->publish_pose(made);
  });
}

int haptic_engage(haptic_session* session, haptic_error* error) {
  return guarded(error, [&] { (*sessions().find(session))->engage(); });
}

int haptic_engage_when_ready(haptic_session* session, haptic_error* error) {
  return guarded(error, [&] { (*sessions().find(session))->engage_when_ready(); });
}

int haptic_engage_refusal(haptic_session* session, haptic_error* error) {
  return guarded(error, [&] {
    const auto refusal = (*sessions().find(session))->engage_refusal();
    if (refusal) throw client::ClientError(*refusal);
    return HAPTIC_NOTHING;
  });
}

int haptic_release(haptic_session* session, haptic_error* error) {
  return guarded(error, [&] { (*sessions().find(session))->release(); });
}

int haptic_update(haptic_session* session, const haptic_settings* wanted, haptic_settings* applied,
                  haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    const client::Settings settings = to_settings(read(wanted, "wanted"));
    if (applied != nullptr) sized(applied, "applied");
    const client::AppliedSettings answer = (*found)->update(settings);
    if (applied != nullptr) write(to_settings(answer), applied);
  });
}

int haptic_next_event(haptic_session* session, haptic_event* event, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(event, "event");
    haptic_event next{};
    const int code = found->next_event(next);
    write(next, event);
    return code;
  });
}

int haptic_statistics_of(haptic_session* session, haptic_statistics* statistics,
                         haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(statistics, "statistics");
    const client::PublishStatistics counted = (*found)->statistics();
    haptic_statistics to{};
    to.published = counted.published;
    to.sent = counted.sent;
    to.conflated = counted.conflated;
    to.planes_left_out = counted.planes_left_out;
    to.accepted = counted.accepted;
    to.rejected_old = counted.rejected_old;
    to.rejected_invalid = counted.rejected_invalid;
    to.backlog = counted.backlog;
    to.round_trip_ns = (*found)->round_trip().count();
    to.lease_epoch = (*found)->lease_epoch();
    to.connected = (*found)->connected() ? 1 : 0;
    write_text(counted.last_rejection, to.last_rejection);
    if (const std::optional<client::UdpLink> udp = (*found)->udp_link()) {
      to.udp_in_use = udp->in_use ? 1 : 0;
      to.udp_round_trip_ns = udp->round_trip.count();
      to.udp_received = udp->received;
      to.udp_lost = udp->lost;
    }
    write(to, statistics);
  });
}
