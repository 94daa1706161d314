// A front that went wrong: hapticd starts it by HAPTICD_FRONT instead of its own, and it attacks
// the owner in the way that $HOSTILE names. It says on standard error what it was refused and what
// it was not ("GOT IN: ...").
//
//   pages     writes to pages that it may only read
//   junk      for as long as it lives: random bytes as samples, requests and messages
//   stop      keeps the queue of requests full, and sends the stop that goes ahead of it
//   layout    names another layout
//   silent    says nothing
//   unbound   is told to bind, and never serves
//   mute      serves, and gives no sign of life

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <iostream>
#include <random>
#include <string>

#include "server/crossing/link_messages.hpp"
#include "server/crossing/packet_socket.hpp"
#include "server/crossing/shared_layout.hpp"

namespace {

using namespace haptic::server;

constexpr int kLink = 3;

void say(const std::string& line) {
  std::cerr << line + "\n" << std::flush;
}

void refused(const char* what, bool got_in) {
  say((got_in ? "GOT IN: " : "refused: ") + std::string(what));
}

FrontMessage of(FrontMessage::Kind kind) {
  FrontMessage message;
  message.kind = kind;
  message.layout = layout_hash();
  return message;
}

struct Link {
  std::vector<Descriptor> descriptors{};

  OwnerMessage hear() {
    OwnerMessage message;
    for (;;) {
      pollfd wait{kLink, POLLIN, 0};
      poll(&wait, 1, -1);
      const Received got = receive(kLink, message, &descriptors);
      if (got == Received::kMessage) return message;
      if (got == Received::kGone) _exit(0);
    }
  }
};

void attack_pages(Link& link) {
  const int pages = link.descriptors[OwnerMessage::kOwnersPages].get();
  refused("to map the owner's pages for writing",
          mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, pages, 0) != MAP_FAILED);
  void* const mapped = mmap(nullptr, 4096, PROT_READ, MAP_SHARED, pages, 0);
  refused("to make them writable", mprotect(mapped, 4096, PROT_READ | PROT_WRITE) == 0);
  refused("to write them by descriptor", pwrite(pages, "x", 1, 0) >= 0);
  refused("to shrink them", ftruncate(pages, 0) == 0);
  refused("to open them again for writing",
          open(("/proc/self/fd/" + std::to_string(pages)).c_str(), O_RDWR) >= 0 &&
              mmap(nullptr, 4096, PROT_WRITE, MAP_SHARED, pages, 0) != MAP_FAILED);
  // And last the write that ends it: SIGSEGV, which hapticd reports.
  *static_cast<volatile char*>(mapped) = 1;
}

[[noreturn]] void send_junk(Link& link) {
  const int samples = link.descriptors[OwnerMessage::kSamples].get();
  std::mt19937_64 random(1);
  ProxySample sample;
  auto* const words = reinterpret_cast<std::uint64_t*>(&sample);
  for (;;) {
    for (std::size_t i = 0; i < sizeof sample / sizeof(std::uint64_t); ++i) words[i] = random();
    sample.plane_count = static_cast<std::uint32_t>(random() % 34);
    if (random() % 2 == 0) sample.device = 0;
    send_sample(samples, SampleKind::kProxy, sample);
    FrontMessage message;
    auto* const bytes = reinterpret_cast<unsigned char*>(&message);
    for (std::size_t i = 0; i < sizeof message; ++i)
      bytes[i] = static_cast<unsigned char>(random());
    message.kind = static_cast<FrontMessage::Kind>(random() % 8);
    if (random() % 4 != 0) message.kind = FrontMessage::Kind::kRequest;
    if (message.kind == FrontMessage::Kind::kCannotServe) continue;
    message.request.kind = static_cast<Request::Kind>(random() % 16);
    if (random() % 2 == 0) message.request.device = 0;
    // No stop: the device is to stay free, so that the test sees a stop of its own.
    if (message.request.kind == Request::Kind::kStop) continue;
    send(kLink, message);
  }
}

/// The queue never runs empty: only the stop of its own slot can be obeyed.
[[noreturn]] void stop_ahead_of_a_queue(Link& link) {
  FrontMessage clear;
  clear.kind = FrontMessage::Kind::kRequest;
  clear.request.kind = Request::Kind::kClear;
  for (clear.request.id = 1000;; ++clear.request.id) {
    while (!send(kLink, clear)) sched_yield();
    // Not before the queue is full for the first time.
    if (clear.request.id == 3000) {
      send_sample(link.descriptors[OwnerMessage::kSamples].get(), SampleKind::kStopAhead,
                  StopAhead{0, "ahead of the requests that wait"});
    }
  }
}

}  // namespace

int main() {
  const std::string mode = std::getenv("HOSTILE") != nullptr ? std::getenv("HOSTILE") : "";
  Link link;
  FrontMessage hello = of(FrontMessage::Kind::kHello);
  if (mode == "layout") ++hello.layout;
  if (mode == "silent") pause();
  send(kLink, hello);
  static_cast<void>(link.hear());  // Welcome
  send(kLink, of(FrontMessage::Kind::kReady));
  std::vector<Descriptor> kept = std::move(link.descriptors);
  static_cast<void>(link.hear());  // Go
  if (mode == "unbound") pause();
  link.descriptors = std::move(kept);
  send(kLink, of(FrontMessage::Kind::kServing));
  if (mode == "pages") attack_pages(link);
  if (mode == "junk") send_junk(link);
  if (mode == "stop") stop_ahead_of_a_queue(link);
  if (mode == "mute") pause();
  return 3;
}
