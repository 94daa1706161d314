// Opens a session, publishes, reads states: by the installed headers alone.
#include <haptic/client/client.hpp>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    haptic::client::Connection server(argv[1]);
    const auto session = server.open({.client_name = "foreign", .nominal_rate_hz = 100});
    const auto first = session->wait_for_state();
    session->publish(haptic::client::Proxy::held(first.x_probe));
    haptic::client::DeviceState state = first;
    for (int i = 0; i < 2000 && state.proxy_seq_used == 0; ++i) state = session->wait_for_state();
    std::printf("sample %llu in use\n", static_cast<unsigned long long>(state.proxy_seq_used));
    return state.proxy_seq_used == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const haptic::client::ClientError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
