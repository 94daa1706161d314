#pragma once
/// A Broadcaster of device 0, fed by an owner as in the server.

#include <memory>

#include "server/front/service/broadcaster.hpp"

namespace haptic::test {

struct Broadcast final : server::FrontPort {
  explicit Broadcast(server::WatchBudget budget) : broadcaster(budget) {}

  static std::shared_ptr<Broadcast> of(server::OwnerPort& owner, double states_per_second) {
    auto made = std::make_shared<Broadcast>(server::WatchBudget(states_per_second));
    owner.connect(made);
    return made;
  }
  void on_newest(std::size_t /*device*/, const server::SerialisedState& state) override {
    broadcaster.on_newest(state);
  }

  server::Broadcaster broadcaster;
};

}  // namespace haptic::test
