#pragma once
/// The daemon in one process, for tests: the App with a front on threads of its own.

#include <memory>
#include <utility>

#include "server/front/server.hpp"
#include "server/owner/link/front_program.hpp"
#include "server/owner/telemetry/tick_metrics.hpp"
#include "tests/server/support/port_of.hpp"

namespace haptic::test {

class FrontThreads final : public server::FrontRunner {
 public:
  explicit FrontThreads(server::App& app)
      : hand_over_(server::front_config(app), app.scene().server, "/no/page"),
        server_(hand_over_.start(), app.owner(),
                {[&app] { return app.facts(); },
                 [ticks = app.tick_metrics()](std::size_t device) { return ticks->totals(device); },
                 {}}) {}
  void start() override { server_.start(); }
  void stop() override { server_.stop(std::chrono::seconds(1)); }
  [[nodiscard]] std::vector<std::string> addresses() const override {
    return hand_over_.addresses();
  }

 private:
  server::HandOver hand_over_;
  server::FrontServer server_;
};

class App final : public server::App {
 public:
  App(server::Scene scene, server::AppOptions options)
      : server::App(std::move(scene), options,
                    [](server::App& app) { return std::make_unique<FrontThreads>(app); }) {}
};

}  // namespace haptic::test
