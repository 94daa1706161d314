#pragma once
/// haptic::client - the C++ client of hapticd. One include for all of it; no gRPC, protobuf or
/// Eigen type appears here.
///
///   haptic::client::Connection server(haptic::client::kDefaultServer);
///   auto session = server.open({.client_name = "my simulation", .nominal_rate_hz = 60});
///   session->engage_when_ready();
///   for (...) {
///     haptic::client::DeviceState state = session->wait_for_state();
///     const std::vector<double> x = step(state.x_probe);  // where the objects let the probe be
///     using haptic::client::Proxy;
///     session->publish(touching ? Proxy::held(x) : Proxy::free());
///   }
///
/// Units are SI. An array has one value per degree of freedom or per virtual coordinate, in the
/// order of DeviceInfo. Everything may be called from any thread; session.hpp and watch.hpp say on
/// which threads callbacks run. Calls that wait for an answer throw ClientError (error.hpp).

#include "haptic/client/connection.hpp"
#include "haptic/client/contact.hpp"
#include "haptic/client/error.hpp"
#include "haptic/client/estimator.hpp"
#include "haptic/client/planes.hpp"
#include "haptic/client/pose.hpp"
#include "haptic/client/session.hpp"
#include "haptic/client/solve.hpp"
#include "haptic/client/types.hpp"
#include "haptic/client/watch.hpp"
