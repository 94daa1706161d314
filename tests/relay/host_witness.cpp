#include "tests/relay/host_witness.hpp"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <future>

namespace haptic::test {
namespace {

using std::chrono::nanoseconds;

nanoseconds monotonic() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::chrono::seconds(t.tv_sec) + nanoseconds(t.tv_nsec);
}

void sleep_until(nanoseconds due) {
  timespec until{};
  until.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(due).count();
  until.tv_nsec = (due % std::chrono::seconds(1)).count();
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

/// s, of all processors since the machine was started (proc(5), /proc/stat, the eighth figure).
double stolen() {
  std::ifstream stat("/proc/stat");
  std::string cpu;
  double ticks = 0.0;
  stat >> cpu;
  for (int figure = 1; figure <= 8; ++figure) stat >> ticks;
  return stat ? ticks / static_cast<double>(sysconf(_SC_CLK_TCK)) : 0.0;
}

}  // namespace

std::vector<int> own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  std::vector<int> processors;
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (CPU_ISSET(i, &set)) processors.push_back(i);
  }
  return processors;
}

int take_processor(int processor, int priority) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(processor, &set);
  if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set)) return error;
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
}

/// One processor's watch, written by its thread alone.
struct HostWitness::Post {
  struct Note {
    nanoseconds from{0}, to{0};
  };

  void watch(const std::atomic<bool>& running) {
    nanoseconds awake = monotonic();
    while (running.load(std::memory_order_relaxed)) {
      const nanoseconds due = awake + kNap;
      sleep_until(due);
      const nanoseconds now = monotonic();
      const std::size_t next = count.load(std::memory_order_relaxed);
      if (now - due > kLate && next < notes.size()) {
        notes[next] = {awake, now};
        count.store(next + 1, std::memory_order_release);
      }
      awake = now;
    }
  }

  int error{0};  ///< set before the constructor returns
  std::array<Note, kStalls> notes{};
  std::atomic<std::size_t> count{0};
};

HostWitness::HostWitness() : stolen_before_(stolen()) {
  std::vector<std::future<void>> taken;
  for (const int processor : own_processors()) {
    Post& post = *posts_.emplace_back(std::make_unique<Post>());
    std::promise<void> done;
    taken.push_back(done.get_future());
    threads_.emplace_back([this, &post, processor, done = std::move(done)]() mutable {
      post.error = take_processor(processor, kPriority);
      done.set_value();
      if (post.error == 0) post.watch(running_);
    });
  }
  for (std::future<void>& each : taken) each.wait();
}

HostWitness::~HostWitness() {
  running_ = false;
  for (std::thread& thread : threads_) thread.join();
}

std::string HostWitness::refusal() const {
  for (const auto& post : posts_) {
    if (post->error == 0) continue;
    return "SCHED_FIFO " + std::to_string(kPriority) + " refused (" + std::strerror(post->error) +
           ")";
  }
  return {};
}

Testimony HostWitness::testimony(nanoseconds origin) const {
  using Seconds = std::chrono::duration<double>;
  Testimony testimony;
  testimony.above_all = refusal().empty() && !posts_.empty();
  for (const auto& post : posts_) {
    const std::size_t count = post->count.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i) {
      testimony.stalls.push_back({Seconds(post->notes[i].from - origin).count(),
                                  Seconds(post->notes[i].to - origin).count()});
    }
  }
  return testimony;
}

std::string HostWitness::summary() const {
  if (!refusal().empty()) return "no witness of the host: " + refusal();
  double longest = 0.0;
  for (const Stall& stall : testimony(nanoseconds(0)).stalls) {
    longest = std::max(longest, stall.to - stall.from);
  }
  if (longest == 0.0) return "no stall of the host";
  char text[80];
  std::snprintf(text, sizeof text, "longest stall of the host %.0f ms, %.0f ms stolen",
                1e3 * longest, 1e3 * (stolen() - stolen_before_));
  return text;
}

}  // namespace haptic::test
