// The front's own means: samples, requests, messages to the owner.

#include <sys/socket.h>

#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include "server/base/steady_now.hpp"
#include "server/crossing/packet_socket.hpp"
#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

using namespace std::chrono_literals;
using server::FrontMessage;
using server::ProxySample;
using server::Request;
using Kind = Request::Kind;

/// Plays a client that is dead, for as long as the command says; asks to have its faults cleared
/// too, locally if the owner believed it.
void press_on(Inside& in, bool clears) {
  Request clear;
  clear.kind = Kind::kClear;
  clear.local = true;
  std::uint64_t seq = std::uint64_t{1} << 40U;
  for (; in.goes_on(); std::this_thread::sleep_for(10ms)) {
    in.owner.post(held(in.spy.epoch, ++seq));
    clear.id = seq;
    if (clears && seq % 10 == 0) in.owner.post(clear);
  }
}

/// Word: "alone": the honest part of the front says no more. "clears": it wants faults cleared.
void pretend(Inside& in) {
  bool clears = false;
  for (const std::string& word : in.words) {
    if (word == "alone") freeze_the_front();
    clears = clears || word == "clears";
  }
  press_on(in, clears);
}

/// Opens a session as the most privileged client, takes the lease and engages.
void operate(Inside& in) {
  const auto ask = [&](Request& request, std::uint64_t id) {
    request.id = id;
    in.owner.post(request);
    while (in.spy.answered != id && in.goes_on()) std::this_thread::sleep_for(1ms);
  };
  Request session;
  ask(session, Spy::kSession);
  Request lease;
  lease.kind = Kind::kOpen;
  lease.session_id = in.spy.session;
  lease.lease.session_id = in.spy.session;
  lease.lease.client_name = "inside";
  lease.lease.nominal_rate_hz = 100.0;
  lease.lease.priority = server::Priority::kOperator;
  ask(lease, Spy::kLease);
  Request engage;
  engage.kind = Kind::kEngage;
  engage.session_id = in.spy.session;
  std::uint64_t seq = 0;
  for (; in.goes_on(); std::this_thread::sleep_for(10ms)) {
    ProxySample sample = held(in.spy.epoch, ++seq);
    if (seq < 30) sample.mode = core::ProxyMode::kFree;
    in.owner.post(sample);
    engage.id = Spy::kLease + seq;
    if (seq == 25) in.owner.post(engage);
  }
  Request close;
  close.kind = Kind::kClose;
  close.session_id = in.spy.session;
  in.owner.post(close);
}

/// Clears of every device, as if they came by the local control socket.
void clears(Inside& in) {
  Request clear;
  clear.kind = Kind::kClear;
  clear.local = true;
  for (clear.id = Spy::kLease; in.goes_on(); ++clear.id) {
    clear.device = static_cast<std::uint32_t>(clear.id % 2);
    in.owner.post(clear);
    std::this_thread::sleep_for(1ms);
  }
}

void flood_of_requests(Inside& in) {
  FrontMessage message;
  message.kind = FrontMessage::Kind::kRequest;
  std::mt19937_64 random(1);
  while (in.goes_on()) {
    Request& request = message.request;
    request.kind = static_cast<Kind>(random() % 13);
    if (request.kind == Kind::kStop) continue;  // that one is allowed
    request.id = random();
    request.device = 1;
    request.session_id = std::to_string(random());
    request.lease.nominal_rate_hz = 100.0;
    in.owner.say(message);
  }
}

void flood_of_samples(Inside& in) {
  std::vector<std::thread> writers;
  for (int i = 0; i < 3; ++i) {
    writers.emplace_back([&in] {
      for (ProxySample sample = held(0, 1); in.goes_on(); ++sample.seq) {
        sample.device = static_cast<std::uint32_t>(sample.seq % 3);
        sample.plane_count = static_cast<std::uint32_t>(sample.seq);
        in.owner.post(sample);
      }
    });
  }
  for (std::thread& each : writers) each.join();
}

/// Steps out of their order, with text that is none.
void lies(Inside& in) {
  FrontMessage message;
  message.text = "\x1b[31mgone\x9b\n2026 forged line";
  for (std::uint8_t kind = 0; in.goes_on(); ++kind) {
    message.kind = static_cast<FrontMessage::Kind>(kind);
    message.layout = kind;
    if (message.kind != FrontMessage::Kind::kRequest) in.owner.say(message);
    std::this_thread::sleep_for(1ms);
  }
}

/// Messages of every size.
void odd_sizes(Inside& in) {
  std::vector<std::byte> bytes(70'000);
  for (std::size_t size = 0; in.goes_on(); size = (size + 997) % bytes.size()) {
    static_cast<void>(server::send_bytes(kLink, std::span(bytes).first(size), {}));
    std::this_thread::sleep_for(1ms);
  }
}

}  // namespace

ProxySample held(std::uint32_t epoch, std::uint64_t seq) {
  ProxySample sample;
  sample.epoch = epoch;
  sample.seq = seq;
  sample.arrival = server::steady_now();
  sample.mode = core::ProxyMode::kHeld;
  sample.position = {0.25, 0.5236};
  return sample;
}

const std::vector<Mode> kLinkModes{{"pretend", pretend},
                                   {"operate", operate},
                                   {"clears", clears},
                                   {"requests", flood_of_requests},
                                   {"samples", flood_of_samples},
                                   {"lies", lies},
                                   {"odd", odd_sizes}};

}  // namespace haptic::hostile
