#include <unistd.h>

#include "tests/bench/network.hpp"
#include "tests/bench/one_way.hpp"
#include "tests/bench/paired.hpp"

namespace haptic::bench {

void stream_one_way(int blocks) {
  const std::string socket = "unix:/tmp/haptic-bench-" + std::to_string(::getpid());
  Product product({"127.0.0.1:0", socket});
  BareServer service;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.AddListeningPort(socket + "-bare", grpc::InsecureServerCredentials());
  builder.RegisterService(&service);
  const auto peer = builder.BuildAndStart();
  const auto row = [&](const char* what, std::size_t ours, const std::string& theirs) {
    print(compare(
        what, "bare gRPC stream", "us",
        [&] { return product_block(product, product.address(ours)).up_us; },
        [&] { return bare_block(service, theirs).up_us; }, 1.3, blocks));
  };
  row("publish -> mailbox one way by gRPC on TCP p50", 0, "127.0.0.1:" + std::to_string(port));
  row("publish -> mailbox one way by gRPC on a UNIX socket p50", 1, socket + "-bare");
  peer->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
}

}  // namespace haptic::bench
