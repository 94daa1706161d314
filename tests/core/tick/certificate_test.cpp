// The certificate of the linearised method in the record of every tick
// (core/METHOD.md#exact-derivatives).
#include <gtest/gtest.h>

#include "haptic/core/model/stylus.hpp"
#include "tests/core/tick/finger_bench.hpp"
#include "tests/report/analysis/passivity_radius.hpp"

namespace haptic::core {
namespace {

using namespace test;

PipelineConfig certified(RendererKind renderer = RendererKind::kSubspaceLinear) {
  PipelineConfig c = config_of(renderer);
  c.passivity_certificate = true;
  return c;
}

/// Moves the finger on a circle around a proxy that stays.
void move(Bench& bench, int i) {
  const double phase = 0.01 * i;
  bench.put(joints(0.5 + 0.3 * std::sin(phase), 0.5 + 0.3 * std::cos(phase)));
}

TEST(CertificateOfATick, IsAbsentUnlessTheSceneAsks) {
  Bench bench(config_of(RendererKind::kSubspaceLinear));
  for (int i = 0; i < 300; ++i) {
    move(bench, i);
    EXPECT_EQ(bench.tick().anchor.certificate.status, CertificateStatus::kOff);
  }
}

TEST(CertificateOfATick, IsTheRenderedForcesMargin) {
  Bench bench(certified());
  bench.engage();
  const Kinematics& finger = *bench.pipeline.config().kinematics;
  const RenderingImpedance impedance{VecA::Constant(1, kStiffness), MatXX::Identity(2, 2)};
  double least = 1.0;
  for (int i = 0; i < 700; ++i) {
    move(bench, i);
    const TickRecord record = bench.tick();
    ASSERT_EQ(record.anchor.certificate.status, CertificateStatus::kComputed);
    const auto want = passivity_certificate(RendererKind::kSubspaceLinear, finger, record.sensed.q,
                                            record.anchor.x, impedance);
    ASSERT_NEAR(record.anchor.certificate.margin, want.value().margin, 1e-11);
    least = std::min(least, record.anchor.certificate.margin);
  }
  EXPECT_LT(least, 0.9);
}

TEST(CertificateOfATick, ChangesNothingElse) {
  Bench plain(config_of(RendererKind::kSubspaceLinear)), watched(certified());
  plain.engage();
  watched.engage();
  for (int i = 0; i < 400; ++i) {
    move(plain, i);
    move(watched, i);
    const TickRecord without = plain.tick();
    TickRecord with = watched.tick();
    ASSERT_FALSE(identical(without, with));
    with.anchor.certificate = {};
    ASSERT_TRUE(identical(without, with)) << i;
  }
}

TEST(CertificateOfATick, IsReplayedToTheBit) {
  Bench bench(certified());
  Pipeline again(bench.pipeline.config());
  for (int i = 0; i < 600; ++i) {
    if (i == 250) ++bench.input.command.engage_id;
    if (i > 460) move(bench, i);
    const TickRecord record = bench.tick();
    ASSERT_TRUE(identical(again.tick(record.input), record)) << i;
  }
}

TEST(CertificateOfATick, SaysWhyThereIsNone) {
  Bench bench(certified());
  bench.shape = [](ProxySnapshot p) {
    p.mode = ProxyMode::kFree;
    return p;
  };
  move(bench, 1);
  EXPECT_EQ(bench.tick().anchor.certificate.status, CertificateStatus::kIdle);
  bench.shape = nullptr;
  EXPECT_EQ(bench.tick().anchor.certificate.status, CertificateStatus::kComputed);
  bench.input.settings.id = 1;
  bench.input.settings.renderer = RendererKind::kSubspaceExact;
  EXPECT_EQ(bench.tick().anchor.certificate.status, CertificateStatus::kOtherRenderer);
}

/// Three actuators, nine coordinates: the general form, eigenvalue and all.
TEST(CertificateOfATick, AllocatesNothingOnAStylus) {
  PipelineConfig c;
  c.kinematics = make_stylus({}, {{"tip", "", OutputKind::kPoint, {{0.03, 0, 0}, {}}},
                                  {"end", "", OutputKind::kPoint, {{-0.10, 0, 0}, {}}},
                                  {"button", "", OutputKind::kPoint, {{0, 0, 0.03}, {}}}});
  c.device.q_lower = VecQ::Constant(6, -3.0);
  c.device.q_upper = VecQ::Constant(6, 3.0);
  c.device.max_effort = VecA::Constant(3, 5.0);
  c.scene.stiffness = (VecA(3) << 2.0, 3.0, 5.0).finished();
  c.scene.damping = VecA::Zero(3);
  c.scene.force_limit = VecA::Constant(3, 5.0);
  c.scene.slew_limit = c.scene.engage_window = VecA::Constant(3, 1e6);
  c.passivity_certificate = true;
  Driven driven(c);
  TickInput& input = driven.input;
  input.device.sample.q = (VecQ(6) << 0.2, 0.6, -1.3, 0.1, 0.2, 0.3).finished();
  VecX x_probe;
  ASSERT_EQ(c.kinematics->position(input.device.sample.q, x_probe), MapStatus::kOk);
  input.proxy.x = x_probe + VecX::Constant(9, 0.004);
  driven.tick();  // its sample is free
  for (int i = 0; i < 50; ++i) {
    input.device.sample.q[i % 6] += 1e-3;
    const Certificate& certificate = driven.tick().anchor.certificate;  // tick() judges
    ASSERT_EQ(certificate.status, CertificateStatus::kComputed);
    ASSERT_NE(certificate.margin, 1.0);
  }
}

}  // namespace
}  // namespace haptic::core
