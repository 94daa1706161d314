#pragma once
/// The daemon in one process, for tests: the App with a front on threads of its own.

#include <memory>
#include <utility>

#include "server/front/app.hpp"
#include "server/owner/app.hpp"
#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::test {

class FrontThreads final : public server::FrontRunner {
 public:
  explicit FrontThreads(server::App& app)
      : app_(app.scene(), app.options().insecure_lab,
             {&app.owner(),
              [&app] { return app.facts(); },
              [ticks = app.tick_metrics()](std::size_t device) { return ticks->totals(device); },
              {}}) {}
  void start() override { app_.start(); }
  void stop() override { app_.stop(); }
  [[nodiscard]] std::vector<std::string> addresses() const override { return app_.addresses(); }
  [[nodiscard]] std::uint16_t metrics_port() const { return app_.metrics_port(); }

 private:
  server::FrontApp app_;
};

class App final : public server::App {
 public:
  App(server::Scene scene, server::AppOptions options)
      : server::App(std::move(scene), options, [this](server::App& app) {
          auto front = std::make_unique<FrontThreads>(app);
          front_ = front.get();
          return front;
        }) {}
  /// The metrics'; 0 if there are none. Between start() and stop().
  [[nodiscard]] std::uint16_t metrics_port() const { return front_->metrics_port(); }

 private:
  FrontThreads* front_{nullptr};
};

}  // namespace haptic::test
