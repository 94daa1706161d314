#pragma once
/// haptic::client - the C++ client of hapticd. No gRPC, protobuf or Eigen type appears here.
///
///   haptic::client::Connection server(haptic::client::kDefaultServer);
///   auto session = server.open({.client_name = "my simulation", .nominal_rate_hz = 60});
///   session->engage_when_ready();
///   for (...) {
///     haptic::client::DeviceState state = session->wait_for_state();
///     session->publish(haptic::client::Proxy::held(step(state.x_probe)));
///   }
///
/// SI units throughout; arrays in the order of DeviceInfo. Threads: session.hpp and watch.hpp say
/// whose thread a callback runs on; everything else may be called from any thread. Destructors cancel
/// what is open, wait for a running callback and join; they never wait for the server (a session that
/// reconnects: 500 ms, for its farewell), and must not be called in a callback of the same object.

#include "haptic/client/connection.hpp"
#include "haptic/client/error.hpp"
#include "haptic/client/link.hpp"
#include "haptic/client/planes.hpp"
#include "haptic/client/pose.hpp"
#include "haptic/client/session.hpp"
#include "haptic/client/types.hpp"
#include "haptic/client/watch.hpp"
