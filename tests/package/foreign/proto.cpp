// The sample of the test vector in proto/README.md, through the installed messages.
#include <haptic/v1/session.pb.h>

#include <cstdio>

int main() {
  haptic::v1::ProxySample sample;
  sample.set_seq(7);
  sample.set_mode(haptic::v1::PROXY_MODE_HELD);
  sample.add_position(0.01);
  sample.add_position(-0.02);
  for (const char byte : sample.SerializeAsString()) {
    std::printf("%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
  }
  std::printf("\n");
}
