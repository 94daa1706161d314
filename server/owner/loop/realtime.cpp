#include "server/owner/loop/realtime.hpp"

#include <array>
#include <cstring>
#include <vector>

#include "haptic/core/error.hpp"
#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

/// A share of the processor below which real-time throttling may strike a 1 kHz loop in earnest.
/// The kernel's default is 0.95.
constexpr double kScantShare = 0.5;

/// "EPERM: Operation not permitted".
std::string error_text(int error) {
  const char* short_name = strerrorname_np(error);
  return std::string(short_name != nullptr ? short_name : "error") + ": " + strerrordesc_np(error);
}

/// The parts of one explanation.
struct Account {
  std::vector<std::string> granted{};
  std::vector<std::string> refused{};
  std::vector<std::string> notes{};
};

/// True if `what` was granted; else the account says why not, and what that means.
bool granted(Account& account, const std::string& what, int error, const std::string& meaning) {
  if (error == 0) return true;
  account.refused.push_back(what + " refused (" + error_text(error) + "): " + meaning);
  return false;
}

std::string why_fifo_was_refused(int error, RealtimeHost& host) {
  std::string why = error_text(error);
  if (error != EPERM) return why;
  if (host.may_set_any_priority()) {
    return why +
           ", although CAP_SYS_NICE is held: the control group or container gives no "
           "real-time budget";
  }
  return why + "; needs CAP_SYS_NICE or RLIMIT_RTPRIO > 0";
}

void ask_for_fifo(const RealtimeRequest& request, RealtimeHost& host, RealtimeGrant& grant,
                  Account& account) {
  int priority = request.priority;
  int error = host.set_fifo(priority);
  if (error == EPERM) {
    // Without the capability a lower priority may still be free for the taking.
    const ResourceLimit limit = host.priority_limit();
    const auto allowed = limit.soft.value_or(99);
    if (allowed > 0 && allowed < static_cast<std::uint64_t>(priority)) {
      priority = static_cast<int>(allowed);
      error = host.set_fifo(priority);
    }
  }
  if (error != 0) {
    account.refused.push_back("SCHED_FIFO refused (" + why_fifo_was_refused(error, host) +
                              "): other programs may delay a tick");
    return;
  }
  grant.facts.sched_fifo = true;
  grant.facts.priority = priority;
  account.granted.push_back("SCHED_FIFO " + std::to_string(priority));
  if (priority != request.priority) {
    account.notes.push_back("RLIMIT_RTPRIO allows priority " + std::to_string(priority) +
                            ", not the scene's " + std::to_string(request.priority));
  }
  const auto share = host.realtime_share();
  if (share && *share < kScantShare) {
    account.notes.push_back("sched_rt_runtime_us leaves all real-time threads together " +
                            std::to_string(static_cast<int>(*share * 100.0)) +
                            " % of the time: the kernel may halt the loop");
  }
}

/// MCL_FUTURE under a limit that binds would fail the next thread's stack, and with it the process:
/// then nothing is locked.
void ask_for_memory(RealtimeHost& host, RealtimeGrant& grant, Account& account) {
  const std::string meaning = "a page fault may delay a tick";
  if (host.memory_limit().soft && !host.may_lock_any_memory()) {
    if (!host.memory_limit().hard) host.raise_memory_limit();
    if (const auto limit = host.memory_limit().soft) {
      account.refused.push_back("memory locking refused (RLIMIT_MEMLOCK is " +
                                std::to_string(*limit / 1024) +
                                " KB, must be unlimited, or CAP_IPC_LOCK held): " + meaning);
      return;
    }
  }
  grant.facts.memory_locked = granted(account, "memory locking", host.lock_memory(), meaning);
  if (grant.facts.memory_locked) account.granted.emplace_back("memory locked");
}

void ask_for_cpu(int cpu, RealtimeHost& host, RealtimeGrant& grant, Account& account) {
  const std::string number = std::to_string(cpu);
  if (!granted(account, "pinning to CPU " + number, host.set_cpu(cpu),
               "the loop may move between CPUs")) {
    return;
  }
  grant.facts.cpu = cpu;
  account.granted.push_back("pinned to CPU " + number);
}

void ask_for_awake_processors(RealtimeHost& host, RealtimeGrant& grant, Account& account) {
  grant.may_keep_awake = granted(account, "/dev/cpu_dma_latency", host.open_idle_latency(),
                                 "idle processors sleep, so the loop wakes up tens of us later");
  if (grant.may_keep_awake)
    account.granted.emplace_back("idle processors stay awake while controlled");
}

void append(std::string& text, const std::vector<std::string>& parts, const char* separator) {
  for (const std::string& part : parts) {
    if (!text.empty()) text += separator;
    text += part;
  }
}

std::string late_fault_clause(const RealtimeRequest& request, const RealtimeGrant& grant) {
  const std::string value = "loop_late_fault is " + milliseconds(grant.loop_late_fault);
  if (request.loop_late_fault) return value + " (the scene's)";
  return grant.facts.sched_fifo ? value : value + " instead of " + milliseconds(kLateFaultRealtime);
}

std::string explain(const RealtimeRequest& request, const RealtimeGrant& grant,
                    const Account& account) {
  std::string text;
  if (request.mode == RealtimeMode::kOff) {
    text = "no real-time scheduling asked for (--realtime=off): other programs may delay a tick";
  }
  append(text, account.refused, "; ");
  std::string granted;
  append(granted, account.granted, ", ");
  if (!granted.empty()) text += (text.empty() ? "" : "; granted: ") + granted;
  append(text, account.notes, "; ");
  return text + "; " + late_fault_clause(request, grant);
}

}  // namespace

std::string_view name(RealtimeMode mode) noexcept {
  static constexpr std::array<std::string_view, 3> kNames{"require", "try", "off"};
  return kNames[static_cast<std::size_t>(mode)];
}

RealtimeGrant apply_realtime(const RealtimeRequest& request, RealtimeHost& host) {
  RealtimeGrant grant;
  grant.facts.requested = name(request.mode);
  Account account;
  grant.facts.timer_slack = granted(account, "timer slack of 1 ns", host.set_timer_slack_ns(1),
                                    "wake-ups may be late by 50 us");
  if (request.cpu) ask_for_cpu(*request.cpu, host, grant, account);
  if (request.mode != RealtimeMode::kOff) {
    ask_for_fifo(request, host, grant, account);
    ask_for_memory(host, grant, account);
    ask_for_awake_processors(host, grant, account);
  }
  host.touch_stack();

  grant.loop_late_fault = request.loop_late_fault.value_or(
      grant.facts.sched_fifo ? kLateFaultRealtime : kLateFaultElsewhere);
  const bool all = account.refused.empty() && account.notes.empty();
  grant.facts.grade = request.mode == RealtimeMode::kOff ? "best-effort"
                      : all                              ? "real-time"
                                                         : "degraded";
  grant.facts.explanation = explain(request, grant, account);
  if (request.mode == RealtimeMode::kRequire && !all) {
    throw core::RealtimeError("--realtime=require: " + grant.facts.explanation.str());
  }
  return grant;
}

}  // namespace haptic::server
