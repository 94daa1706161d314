#pragma once
/// One way from publish() to the mailbox, and from the tick to the client's callback, p50 of a
/// block: by the product, and by the bare stream.

#include "haptic/client/client.hpp"
#include "tests/bench/bare_stream.hpp"
#include "tests/bench/product.hpp"

namespace haptic::bench {

struct OneWay {
  double up_us{0.0}, down_us{0.0};  ///< p50
  /// The same of what comes before the callback (Arrivals). 0: not known.
  double found_us{0.0}, written_us{0.0};
};

inline OneWay product_block(Product& product, const std::string& address) {
  std::mutex mutex;
  std::vector<double> down;
  client::Connection connection(address);
  client::SessionOptions options;
  options.client_name = "bench";
  options.nominal_rate_hz = 250;
  options.on_state = [&](const client::DeviceState& state) {
    const std::lock_guard lock(mutex);
    down.push_back(static_cast<double>(now_ns() - state.server_time_ns) * 1e-3);
  };
  std::vector<std::int64_t> published;
  {
    const auto session = connection.open(options);
    product.arrivals.restart();
    published = paced(kSamples, kEvery, [&](auto) {
      session->publish(client::Proxy::held({0.4, 0.5}));
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::lock_guard lock(product.arrivals.mutex);
  return {percentile(ways_us(product.arrivals.born, published), 0.5), percentile(down, 0.5),
          percentile(product.arrivals.found_us, 0.5), percentile(product.arrivals.written_us, 0.5)};
}

inline OneWay bare_block(BareServer& service, const std::string& address) {
  {
    const std::lock_guard lock(service.mutex);
    service.up_us.clear();
  }
  std::vector<double> down;
  {
    BareClient client(address);
    paced(kSamples, kEvery, [&](std::uint64_t i) { client.send(i); });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::lock_guard lock(client.mutex);
    down = client.down_us;
  }
  const std::lock_guard lock(service.mutex);
  return {percentile(service.up_us, 0.5), percentile(down, 0.5)};
}

}  // namespace haptic::bench
