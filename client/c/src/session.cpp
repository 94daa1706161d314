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
    write(to_device((*found)->device()), sized(device, "device"));
  });
}

int haptic_newest_state(haptic_session* session, haptic_state* state, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(state, "state");
    write(to_state((*found)->state()), state);
  });
}

int haptic_wait_for_state(haptic_session* session, uint32_t timeout_ms, haptic_state* state,
                          haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    sized(state, "state");
    write(to_state((*found)->wait_for_state(std::chrono::milliseconds(timeout_ms))), state);
  });
}

int haptic_publish_free(haptic_session* session, haptic_error* error) {
  return guarded(error, [&] { (*sessions().find(session))->publish(client::Proxy::free()); });
}

int haptic_publish_held(haptic_session* session, const double* x, size_t count,
                        haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    (*found)->publish(
        client::Proxy::held(to_position(x, count, (*found)->device().coordinates.size())));
  });
}

int haptic_publish_planes(haptic_session* session, const double* x, size_t count,
                          const haptic_plane* planes, size_t plane_count, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = sessions().find(session);
    const std::size_t coordinates = (*found)->device().coordinates.size();
    std::vector<double> position = to_position(x, count, coordinates);
    (*found)->publish(
        client::Proxy::behind(read_planes(planes, plane_count, coordinates), std::move(position)));
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
    write(to, statistics);
  });
}
