/// The C++ of client/README.md as it stands there, compiled: each piece inside what its reader has
/// around it.

#include <array>
#include <utility>
#include <vector>

#include "haptic/client/client.hpp"

namespace haptic::readme {

extern bool running, touching;
std::vector<double> simulate(const std::vector<double>& x_probe);
struct Camera {
  std::pair<std::array<double, 3>, std::array<double, 4>> wait_for_pose();
};
extern Camera camera;

void the_shortest() {
#include "client_readme_1.inc"
}

void by_tls() {
#include "client_readme_2.inc"
}

struct Pad {
  std::size_t phalanx;
  double along;
};

void tells_contacts(client::Session* session, const std::vector<Pad>& pads,
                    const std::vector<double>& x, std::chrono::nanoseconds period, double radius,
                    double coupling) {
  using namespace client;
#include "client_readme_3.inc"
}

void says_where_the_palm_is(client::Connection& server){
#include "client_readme_4.inc"
}

std::vector<double> where_the_device_can_push(const client::DeviceState& state,
                                              const std::array<double, 2>& n, double d) {
#include "client_readme_5.inc"
  return x;
}

}  // namespace haptic::readme
