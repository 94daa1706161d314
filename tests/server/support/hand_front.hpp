#pragma once
/// A front of device 0 that a test drives: requests are calls with callbacks. Sessions have short
/// names chosen by the test ("s1") and are admitted at their first use.

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "haptic/core/tick/tick_record.hpp"
#include "haptic/v1/session.pb.h"
#include "server/front/session/front.hpp"

namespace haptic::test {

using server::Outcome;
struct Done {};

class HandFront final : public server::Front {
 public:
  using Kind = server::Request::Kind;
  using LeaseAnswer = std::function<void(const Outcome<server::Lease>&)>;
  using DoneAnswer = std::function<void(const Outcome<Done>&)>;
  using ClearAnswer = std::function<void(const Outcome<core::FaultSet>&)>;
  enum class Ending : std::uint8_t { kGivenUp, kLost };

  /// Connected to `owner`, which must outlive it.
  static std::shared_ptr<HandFront> of(server::OwnerPort& owner) {
    auto front = std::make_shared<HandFront>(owner);
    owner.connect(front);
    return front;
  }
  using Front::Front;

  void open_controller(const server::LeaseRequest& wish, core::TimePoint now, LeaseAnswer answer) {
    if (closed_.erase(wish.session_id.str()) > 0) ids_.erase(wish.session_id.str());
    server::Request request = by(wish.session_id.str(), Kind::kOpen);
    request.lease = wish;
    request.lease.resume = wish.resume.empty() ? wish.resume : id_of(wish.resume.str());
    request.time = now;
    ask_for(request, &server::Answer::lease, std::move(answer));
  }
  std::uint64_t engage(const std::string& name, DoneAnswer answer) {
    return ask_done(by(name, Kind::kEngage), std::move(answer));
  }
  std::uint64_t release(const std::string& name, DoneAnswer answer) {
    return ask_done(by(name, Kind::kRelease), std::move(answer));
  }
  std::uint64_t emergency_stop(const std::string& reason, DoneAnswer answer) {
    server::Request request{.kind = Kind::kStop, .text = reason};
    return ask_done(request, std::move(answer));
  }
  void clear_faults(core::FaultSet faults, ClearAnswer answer) {
    server::Request request{.kind = Kind::kClear, .faults = faults};
    ask_for(request, &server::Answer::faults, std::move(answer));
  }
  Outcome<server::Settings> update_settings(const std::string& name,
                                            const server::SettingsRequest& settings) {
    server::Request request = by(name, Kind::kSettings);
    request.settings = settings;
    Outcome<server::Settings> outcome{server::Refusal{}};
    ask_for<server::Settings>(request, &server::Answer::settings,
                              [&outcome](const auto& answer) { outcome = answer; });
    return outcome;
  }
  void close(const std::string& name, Ending ending = Ending::kGivenUp) {
    tell(by(name, ending == Ending::kLost ? Kind::kLose : Kind::kClose));
    closed_.insert(name);
  }
  std::shared_ptr<server::EventQueue> subscribe(const std::string& name) {
    static_cast<void>(id_of(name));
    return Front::subscribe(0);
  }

  [[nodiscard]] server::DeviceStatus status() const { return owner().status(0); }
  [[nodiscard]] std::string controller() const { return status().controller.str(); }
  [[nodiscard]] unsigned observers() const { return status().observers; }
  /// `name`: the test's, or a session's secret one.
  [[nodiscard]] bool holds_lease(const std::string& name) {
    const auto known = ids_.find(name);
    return status().holder == (known != ids_.end() ? known->second : server::SessionId(name));
  }
  /// The owner's state of a record that was drained.
  [[nodiscard]] v1::DeviceState state_of(const core::TickRecord& record) const {
    v1::DeviceState state;
    for (const auto& [tick, bytes] : states_) {
      if (tick != record.beat.tick) continue;
      EXPECT_TRUE(state.ParseFromString(bytes));
    }
    return state;
  }

  /// The secret name of a session.
  server::SessionId id_of(const std::string& name) {
    const auto known = ids_.find(name);
    if (known != ids_.end()) return known->second;
    server::Request request{.kind = Kind::kAdmitSession};
    server::SessionId id;
    ask(request, [&id](const server::Answer& a) { id = a.session_id; });
    return ids_[name] = id;
  }

  void on_newest(std::size_t /*device*/, const server::SerialisedState& state) override {
    const auto bytes = state.message();
    states_.emplace_front(state.tick, std::string(bytes.begin(), bytes.end()));
    if (states_.size() > 512) states_.pop_back();
  }

 private:
  server::Request by(const std::string& name, Kind kind) {
    return {.kind = kind, .session_id = id_of(name)};
  }
  template <typename T>
  void ask_for(const server::Request& request, T server::Answer::*value,
               std::function<void(const Outcome<T>&)> answer) {
    ask(request, [value, answer = std::move(answer)](const server::Answer& a) {
      answer(a.refusal ? Outcome<T>(*a.refusal) : Outcome<T>(a.*value));
    });
  }
  std::uint64_t ask_done(const server::Request& request, DoneAnswer answer) {
    return ask(request, [answer = std::move(answer)](const server::Answer& a) {
      answer(a.refusal ? Outcome<Done>(*a.refusal) : Outcome<Done>(Done{}));
    });
  }

  std::map<std::string, server::SessionId> ids_{};
  std::set<std::string> closed_{};  ///< known still: a lease may be resumed by its old name
  std::deque<std::pair<std::uint64_t, std::string>> states_{};  ///< by tick
};

}  // namespace haptic::test
