/// A field of a contact that stands in the messages alone: `stickiness` of add_field.py goes from
/// the client to core, is checked on its way, and has no line of code there.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "convert.hpp"
#include "convert_plane.hpp"
#include "haptic/client/contact.hpp"
#include "server/front/session/plane_fields.hpp"
#include "server/owner/ingress/ingress.hpp"

namespace haptic {
namespace {

class NewContactField : public testing::Test {
 protected:
  /// Publishes a contact that has this stickiness in C; the coupling is 2 N/m.
  server::Verdict publish(double stickiness) {
    client::Contact contact{.point = client::point_itself({0.0, 0.0, 0.0}),
                            .normal = {1.0, 0.0, 0.0}};
    haptic_contact in_c{};
    in_c.stickiness = stickiness;
    c::read_fields(in_c, contact);
    v1::Plane message, arrived;
    client::write(client::contact_at({0.0, 0.0, 0.0}, contact, 2.0), message);
    EXPECT_TRUE(arrived.ParseFromString(message.SerializeAsString()));
    server::ProxySample sample;
    sample.epoch = 1;
    sample.seq = ++seq_;
    sample.arrival = core::TimePoint(std::chrono::milliseconds(20 * seq_));
    sample.mode = core::ProxyMode::kPlanes;
    sample.position = {0.0, 0.0, 0.0};
    sample.plane_count = 1;
    sample.planes[0].normal = {-1.0, 0.0, 0.0};
    server::read_fields(arrived, sample.planes[0]);
    return ingress_.accept(sample);
  }
  const core::PlaneSet& planes() {
    static_cast<void>(mailbox_.take());
    return mailbox_.value().planes;
  }

 private:
  void SetUp() override { ingress_.begin_lease(1, 60.0, std::chrono::milliseconds(100)); }
  core::Mailbox<core::ProxySnapshot> mailbox_{};
  server::Ingress ingress_{mailbox_, 3};
  int seq_{0};
};

TEST_F(NewContactField, ReachesCore) {
  EXPECT_TRUE(publish(3.0).used());
  ASSERT_EQ(planes().stickiness.size(), 1);
  EXPECT_EQ(planes().stickiness[0], 1.5) << "3 N by the coupling";
  EXPECT_TRUE(planes().fits(3));
  EXPECT_TRUE(publish(0.0).used());
  EXPECT_EQ(planes().stickiness.size(), 0) << "no contact has it";
}

TEST_F(NewContactField, IsCheckedByItsOption) {
  for (const auto& [stickiness, told] :
       {std::pair(-1.0, "-0.5"), std::pair(12.0, "6"), std::pair(std::nan(""), "nan")}) {
    const server::Verdict verdict = publish(stickiness);
    EXPECT_EQ(verdict.verdict, server::IngressVerdict::kBadPlane);
    EXPECT_EQ(verdict.why.str(),
              "planes[0].stickiness = " + std::string(told) + ": must lie within 0..5");
  }
  EXPECT_TRUE(publish(10.0).used());
}

}  // namespace
}  // namespace haptic
