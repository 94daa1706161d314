/// The C++ of client/README.md as it stands there, compiled: each piece inside what its reader has
/// around it.

#include <array>
#include <utility>
#include <vector>

#include "haptic/client/client.hpp"

namespace haptic::readme {

extern bool running;
struct Simulated {
  std::vector<client::Plane> contacts;
  std::vector<double> x;
};
Simulated simulate(const std::vector<double>& x_probe);
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

std::vector<client::Contact> contacts_near(const std::vector<double>& x, double within);

void solves_its_proxy(client::Session* session, const client::DeviceState& state, double near,
                      double coupling, std::vector<double> last) {
  using namespace client;
#include "client_readme_4.inc"
}

void says_where_the_palm_is(client::Connection& server) {
#include "client_readme_5.inc"
}

}  // namespace haptic::readme
