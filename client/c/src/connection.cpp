/// The functions of haptic.h that take a connection.

#include "border.hpp"
#include "convert.hpp"

using namespace haptic::c;  // every definition here is one of haptic.h
namespace client = haptic::client;

const char* haptic_version(void) {
  return HAPTIC_VERSION;
}

int haptic_connect(const haptic_connect_options* options, haptic_connection** connection,
                   haptic_error* error) {
  return guarded(error, [&] {
    *given(connection, "connection") = nullptr;
    refuse_in_a_child();
    const haptic_connect_options wanted = read(options, "options");
    const std::string address = given(wanted.address, "options->address");
    const client::TlsOptions tls{.ca_file = text_or(wanted.ca_file, ""),
                                 .certificate_file = text_or(wanted.certificate_file, ""),
                                 .key_file = text_or(wanted.key_file, ""),
                                 .server_name = text_or(wanted.server_name, "")};
    *connection =
        connections().add(wanted.tls != 0 ? std::make_shared<client::Connection>(address, tls)
                                          : std::make_shared<client::Connection>(address));
  });
}

int haptic_disconnect(haptic_connection* connection) {
  return guarded(nullptr, [&] { connections().take(connection).reset(); });
}

int haptic_server(haptic_connection* connection, haptic_server_info* info, haptic_error* error) {
  return guarded(error, [&] {
    const auto found = connections().find(connection);
    sized(info, "info");
    write(to_struct<haptic_server_info>(found->server_info()), info);
  });
}

int haptic_health(haptic_connection* connection, const char* device, int32_t* healthy,
                  haptic_error* error) {
  return guarded(error, [&] {
    *given(healthy, "healthy") = 0;
    *healthy = connections().find(connection)->healthy(text_or(device, "")) ? 1 : 0;
  });
}

int haptic_devices(haptic_connection* connection, haptic_device* devices, size_t capacity,
                   size_t* count, haptic_error* error) {
  return guarded(error, [&] {
    *given(count, "count") = 0;
    if (capacity > 0) sized(devices, "devices");
    const std::vector<client::DeviceInfo> found = connections().find(connection)->devices();
    *count = found.size();
    write_each(found, devices, capacity, to_struct<haptic_device, client::DeviceInfo>);
  });
}

int haptic_emergency_stop(haptic_connection* connection, const char* device, const char* reason,
                          char* stopped, size_t stopped_size, haptic_error* error) {
  return guarded(error, [&] {
    if (stopped_size > 0) *given(stopped, "stopped") = '\0';
    std::string names;
    for (const std::string& name :
         connections().find(connection)->emergency_stop(text_or(device, ""), text_or(reason, ""))) {
      if (names.size() + name.size() + 2 > stopped_size) break;  // whole names only
      names += (names.empty() ? "" : "\n") + name;
    }
    if (stopped_size > 0) std::memcpy(stopped, names.c_str(), names.size() + 1);
  });
}

int haptic_clear_fault(haptic_connection* connection, const char* device, uint32_t faults,
                       uint32_t* cleared, haptic_error* error) {
  return guarded(error, [&] {
    if (cleared != nullptr) *cleared = 0;
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
      if ((faults >> bit & 1U) != 0) wanted.push_back(bit);
    }
    std::uint32_t bits = 0;
    for (const std::uint32_t bit :
         connections().find(connection)->clear_fault(text_or(device, ""), wanted)) {
      if (bit < 32) bits |= 1U << bit;
    }
    if (cleared != nullptr) *cleared = bits;
  });
}

int haptic_open(haptic_connection* connection, const haptic_session_options* options,
                haptic_session** session, haptic_error* error) {
  return guarded(error, [&] {
    *given(session, "session") = nullptr;
    client::SessionOptions wanted = to_options(read(options, "options"));
    const auto found = connections().find(connection);
    *session = sessions().add(std::make_shared<Session>(*found, std::move(wanted)));
  });
}
