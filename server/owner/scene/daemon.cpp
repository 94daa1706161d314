// The daemon in a scene: addresses, TLS, loop, recording.
#include <algorithm>
#include <set>

#include "server/base/figures.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

/// Default of loop_late_fault with hardware on a real-time host
/// (proto/README.md#states-of-a-device): the smaller of the two that the app may choose.
constexpr core::Duration kTightestLateFault{8ms};
constexpr int kMostCpus = 1024;                // CPU_SETSIZE
constexpr std::size_t kLongestUnixPath = 107;  // sockaddr_un

/// In the order of highest_priority's words.
constexpr Priority kPriorities[] = {Priority::kTest, Priority::kPrimary, Priority::kOperator};

bool is_host_and_port(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  return matches(text, R"((\[[0-9a-fA-F:.]+(%[\w.-]+)?\]|(?!unix:)[\w.-]+):[0-9]{1,5})") &&
         std::stoi(text.substr(colon + 1)) <= 65535;
}

bool any_port(const std::string& address) {
  return is_host_and_port(address) && address.ends_with(":0");
}

TlsConfig read_tls(const Part<v1::TlsScene>& part) {
  TlsConfig tls;
  if (part->certificate().empty()) part.missing("certificate", "the name of a PEM file");
  if (part->key().empty()) part.missing("key", "the name of a PEM file");
  tls.certificate = part.file("certificate", "a PEM file");
  tls.key = part.file("key", "a PEM file");
  tls.client_ca = part.file("client_ca", "a PEM file");
  std::set<std::string> names;
  for (const auto& client : part.parts<v1::TlsClientScene>("client")) {
    const std::string& name = client->name();
    if (name.empty()) client.missing("name", "one of its certificate");
    if (!names.insert(name).second) {
      client.wrong("name", quoted(name), "must be another: this one is listed already");
    }
    if (tls.client_ca.empty()) {
      client.wrong("name", quoted(name), "needs server.tls.client_ca, which verifies this name");
    }
    const std::size_t highest = client.word("highest_priority", {"test", "primary", "operator"});
    tls.clients.push_back({name, kPriorities[highest]});
  }
  return tls;
}

}  // namespace

std::string address_problem(const std::string& address) {
  const bool is_unix = matches(address, "unix:/.{1," + std::to_string(kLongestUnixPath - 1) + "}");
  if (is_unix || is_host_and_port(address)) return {};
  return R"(must be "host:port", "[v6]:port" (port 0 to 65535) or "unix:/path")";
}

std::vector<std::string> read_addresses(
    const Fields& part, const google::protobuf::RepeatedPtrField<std::string>& listen,
    std::set<std::string>& taken) {
  std::vector<std::string> addresses(listen.begin(), listen.end());
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    const std::string& address = addresses[i];
    if (const std::string why = address_problem(address); !why.empty()) {
      part.wrong({"listen", i}, quoted(address), why);
    } else if (!any_port(address) && !taken.insert(address).second) {
      part.wrong({"listen", i}, quoted(address), "must be another: this one is listed already");
    }
  }
  return addresses;
}

ServerScene read_server(const Part<v1::ServerScene>& part) {
  ServerScene server;
  server.offline = part->has_offline();
  if (server.offline) {
    const bool network = !part->listen().empty() || part->has_udp_listen() ||
                         part->has_metrics_listen() || part->has_web() || part->has_tls();
    if (network) {
      part.wrong("offline", "{}", "not with listen, udp_listen, metrics_listen, web or tls");
    }
  } else if (part->listen().empty()) {
    part->add_listen(server.listen.front());
  }
  std::set<std::string> addresses;
  server.listen = read_addresses(part, part->listen(), addresses);
  const auto host_and_port = [&](const char* field, const std::string& address) {
    if (address.empty() || is_host_and_port(address)) return;
    part.wrong(field, quoted(address), R"(must be "host:port" or "[v6]:port" (port 0 to 65535))");
  };
  host_and_port("udp_listen", server.udp_listen = part->udp_listen());
  host_and_port("metrics_listen", server.metrics_listen = part->metrics_listen());
  server.lease_timeout = part.duration("lease_timeout", server.lease_timeout, {500ms, 60s});
  server.max_sessions = static_cast<unsigned>(part.whole_number("max_sessions", 32, 1, 256));
  if (part->has_web()) server.web = read_web(part.part<v1::WebScene>("web"), addresses);
  if (part->has_tls()) server.tls = read_tls(part.part<v1::TlsScene>("tls"));
  return server;
}

LoopScene read_loop(const Part<v1::LoopScene>& part, std::vector<DeviceScene>& devices) {
  LoopScene loop;
  const bool hardware = std::any_of(devices.begin(), devices.end(), [](const DeviceScene& device) {
    return device.source == nullptr || device.source->is_hardware();
  });
  loop.period = part.duration("period", loop.period, {500us, 10ms});
  const DurationRange late{core::Duration(1), 10s};
  loop.loop_late_fault = hardware
                             ? part.duration("loop_late_fault", late)
                             : part.duration("loop_late_fault", kLateFaultWithoutHardware, late);
  if (loop.loop_late_fault && *loop.loop_late_fault <= loop.period) {
    part.wrong("loop_late_fault", milliseconds(*loop.loop_late_fault),
               "must be above the period, " + milliseconds(loop.period));
  } else if (!part->has_loop_late_fault() && loop.period >= kTightestLateFault) {
    part.wrong("period", milliseconds(loop.period),
               "must be below loop_late_fault, which is " + milliseconds(kTightestLateFault) +
                   " by default on a real-time host: give a longer one");
  }
  loop.priority = part.whole_number("priority", loop.priority, 1, 98);
  if (part->has_cpu()) loop.cpu = part.whole_number("cpu", 0, 0, kMostCpus - 1);
  loop.paced_by = part->paced_by();
  const int full = part.whole_number(
      "late_bucket_full", hardware ? core::LateBucket::kFull : kLateBucketWithoutHardware, 10,
      1'000'000);
  for (DeviceScene& device : devices) device.pipeline.late_bucket_full = full;
  return loop;
}

RecordScene read_record(const Part<v1::RecordScene>& part) {
  const std::filesystem::path file(part->file());
  if (part->file().empty()) {
    part.missing("file", "the name of a .csv file");
  } else if (file.extension() != ".csv") {
    part.wrong("file", quoted(part->file()), "must end in \".csv\"");
  }
  return {file, part->compare_renderers(), part->overwrite()};
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
