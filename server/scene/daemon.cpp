// What a scene says about the daemon: addresses, TLS, loop, recording.
#include <algorithm>
#include <cctype>
#include <set>

#include "haptic/core/error.hpp"
#include "server/base/figures.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

/// Default of loop_late_fault with hardware on a real-time host
/// (proto/README.md#states-of-a-device): the smaller of the two that the app may choose.
constexpr core::Duration kTightestLateFault{8ms};
constexpr int kMostCpus = 1024;                // CPU_SETSIZE
constexpr std::size_t kLongestUnixPath = 107;  // sockaddr_un

bool is_port(const std::string& text) {
  const bool digits = !text.empty() && text.size() <= 5 &&
                      text.find_first_not_of("0123456789") == std::string::npos;
  return digits && std::stoi(text) <= 65535;
}

/// "host:port", "[v6]:port" or "unix:/path": the form only. Whether it can be
/// served is said when it is bound.
bool is_address(const std::string& text) {
  const std::string scheme = "unix:";
  if (text.rfind(scheme, 0) == 0) {
    const std::string path = text.substr(scheme.size());
    return path.size() >= 2 && path.size() <= kLongestUnixPath && path.front() == '/';
  }
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || !is_port(text.substr(colon + 1))) return false;
  const std::string host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    return host.find_first_not_of("0123456789abcdefABCDEF:.", 1) == host.size() - 1;
  }
  return !host.empty() && std::all_of(host.begin(), host.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-';
  });
}

Priority read_priority(const std::string& text, const FieldReader& reader) {
  for (const Priority priority : {Priority::kTest, Priority::kPrimary, Priority::kOperator}) {
    if (text == name(priority)) return priority;
  }
  reader.wrong("highest_priority", quoted(text), R"(must be "test", "primary" or "operator")");
  return Priority::kTest;
}

TlsConfig read_tls(v1::TlsScene& message, const std::filesystem::path& folder, Problems& problems) {
  const FieldReader reader(message, "server.tls", problems);
  TlsConfig tls;
  if (message.certificate().empty()) reader.missing("certificate", "the name of a PEM file");
  if (message.key().empty()) reader.missing("key", "the name of a PEM file");
  const std::string what = "a PEM file";
  tls.certificate = reader.file("certificate", folder, what);
  tls.key = reader.file("key", folder, what);
  tls.client_ca = reader.file("client_ca", folder, what);
  std::set<std::string> names;
  for (int i = 0; i < message.client_size(); ++i) {
    v1::TlsClientScene& client = *message.mutable_client(i);
    const FieldReader its(client, reader.path(entry("client", static_cast<std::size_t>(i))),
                          problems);
    if (client.name().empty()) its.missing("name", "one of its certificate");
    if (!names.insert(client.name()).second) {
      its.wrong("name", quoted(client.name()), "must be another: this one is listed already");
    }
    if (tls.client_ca.empty()) {
      its.wrong("name", quoted(client.name()),
                "needs server.tls.client_ca, which verifies this name");
    }
    tls.clients.push_back({client.name(), read_priority(client.highest_priority(), its)});
  }
  return tls;
}

}  // namespace

ServerScene read_server(v1::ServerScene& message, const std::filesystem::path& folder,
                        Problems& problems) {
  const FieldReader reader(message, "server", problems);
  ServerScene server;
  if (message.listen().empty()) message.add_listen(server.listen.front());
  server.listen.assign(message.listen().begin(), message.listen().end());
  std::set<std::string> addresses;
  for (std::size_t i = 0; i < server.listen.size(); ++i) {
    const std::string& address = server.listen[i];
    const std::string field = entry("listen", i);
    if (!is_address(address)) {
      reader.wrong(field, quoted(address),
                   R"(must be "host:port", "[v6]:port" (port 0 to 65535) or "unix:/path")");
    } else if (!addresses.insert(address).second) {
      reader.wrong(field, quoted(address), "must be another: this one is listed already");
    }
  }
  const auto host_and_port = [&](const char* field, const std::string& address) {
    if (address.empty() || (is_address(address) && address.rfind("unix:", 0) != 0)) return;
    reader.wrong(field, quoted(address), R"(must be "host:port" or "[v6]:port" (port 0 to 65535))");
  };
  host_and_port("udp_listen", server.udp_listen = message.udp_listen());
  host_and_port("metrics_listen", server.metrics_listen = message.metrics_listen());
  server.lease_timeout = reader.duration("lease_timeout", server.lease_timeout, {500ms, 60s});
  if (!message.has_max_sessions()) message.set_max_sessions(server.max_sessions);
  server.max_sessions = message.max_sessions();
  reader.whole_number("max_sessions", message.max_sessions(), 1, 256);
  if (message.has_tls()) server.tls = read_tls(*message.mutable_tls(), folder, problems);
  return server;
}

LoopScene read_loop(v1::LoopScene& message, std::vector<DeviceScene>& devices, Problems& problems) {
  const FieldReader reader(message, "loop", problems);
  LoopScene loop;
  const bool hardware = std::any_of(devices.begin(), devices.end(), [](const DeviceScene& device) {
    return device.source == nullptr || device.source->is_hardware();
  });
  loop.period = reader.duration("period", loop.period, {500us, 10ms});
  const DurationRange late{core::Duration(1), 10s};
  loop.loop_late_fault = hardware
                             ? reader.duration("loop_late_fault", late)
                             : reader.duration("loop_late_fault", kLateFaultWithoutHardware, late);
  if (loop.loop_late_fault && *loop.loop_late_fault <= loop.period) {
    reader.wrong("loop_late_fault", milliseconds(*loop.loop_late_fault),
                 "must be above the period, " + milliseconds(loop.period));
  } else if (!message.has_loop_late_fault() && loop.period >= kTightestLateFault) {
    reader.wrong("period", milliseconds(loop.period),
                 "must be below loop_late_fault, which is " + milliseconds(kTightestLateFault) +
                     " by default on a real-time host: give a longer one");
  }
  if (!message.has_priority()) message.set_priority(loop.priority);
  loop.priority = message.priority();
  reader.whole_number("priority", loop.priority, 1, 98);
  if (message.has_cpu()) {
    loop.cpu = message.cpu();
    reader.whole_number("cpu", message.cpu(), 0, kMostCpus - 1);
  }
  loop.paced_by = message.paced_by();
  if (!message.has_late_bucket_full()) {
    message.set_late_bucket_full(hardware ? core::LateBucket::kFull : kLateBucketWithoutHardware);
  }
  reader.whole_number("late_bucket_full", message.late_bucket_full(), 10, 1'000'000);
  for (DeviceScene& device : devices) device.pipeline.late_bucket_full = message.late_bucket_full();
  return loop;
}

RecordScene read_record(v1::RecordScene& message, Problems& problems) {
  const FieldReader reader(message, "record", problems);
  const std::filesystem::path file(message.file());
  if (message.file().empty()) {
    reader.missing("file", "the name of a .csv file");
  } else if (file.extension() != ".csv") {
    reader.wrong("file", quoted(message.file()), "must end in \".csv\"");
  }
  return {file, message.compare_renderers()};
}

void check_pacing(const LoopScene& loop, hw::Device& device) {
  const std::string field = "loop.paced_by = " + quoted(loop.paced_by) + ": ";
  if (device.sample_signal() == nullptr) {
    throw core::DeviceError(field + "this device has no clock of its own; must be a board");
  }
  const core::Duration period = device.info().limits.sample_period;
  if (period == loop.period) return;
  throw core::DeviceError(field + "this board takes a sample every " + milliseconds(period) +
                          "; must be loop.period, " + milliseconds(loop.period));
}

}  // namespace haptic::server
