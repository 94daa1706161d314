#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/ingress/ingress.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace {

using server::Ingress;

constexpr int kCoordinates = 3;
constexpr int kMostPlanes = 9;  // more than are allowed
constexpr int kMostValues = 5;  // more than there are coordinates

/// A sample of anything.
struct AnySample {
  explicit AnySample(FuzzReader& reader) {
    sample.epoch = reader.byte() % 4;
    sample.seq = reader.number(reader.byte() % 2 == 0 ? 1 : 8);
    sample.mode = static_cast<core::ProxyMode>(reader.byte() % 4);
    sample.valid_for = core::Duration(static_cast<std::int64_t>(reader.number(8)));
    sample.position.count = reader.byte() % (kMostValues + 1);
    for (int i = 0; i < kMostValues; ++i) sample.position.value[i] = reader.real();
    sample.plane_count = reader.byte() % (kMostPlanes + 1);
    for (std::uint32_t p = 0; p < std::min<std::uint32_t>(sample.plane_count, core::kMaxPlanes);
         ++p) {
      server::PlaneSample& plane = sample.planes[p];
      for (int i = 0; i < kCoordinates; ++i) plane.normal.value[i] = reader.real();
      plane.normal.count = reader.byte() % 8 == 0 ? 2 : kCoordinates;
      plane.offset = reader.real();
    }
  }
  server::ProxySample sample{};
};

class Door {
 public:
  std::string run(FuzzInput input) {
    FuzzReader reader(input);
    while (!reader.empty() && finding_.empty()) {
      const std::uint8_t what = reader.byte();
      now_ += std::chrono::microseconds(reader.number(3));
      if (what < 16) {
        ingress_.begin_lease(reader.byte() % 4, 1.0 + reader.byte() * 7.8,
                             std::chrono::milliseconds(100));
        newest_ = 0;
      } else if (what < 24) {
        ingress_.end_lease();
      } else {
        take(AnySample(reader));
      }
    }
    return finding_;
  }

 private:
  void take(AnySample any) {
    any.sample.arrival = now_;
    const server::Verdict verdict = ingress_.accept(any.sample);
    const bool used = verdict.used();
    ++calls_;
    const server::IngressCounters c = ingress_.counters();
    if (std::accumulate(c.count.begin(), c.count.end(), std::uint64_t{0}) != calls_) {
      finding_ = "a call that no counter counts";
    }
    if (used != verdict.why.empty()) finding_ = "a refusal without a word, or a word without one";
    // At the beginning of a lease the mailbox has an empty snapshot; that one is not looked at.
    if (mailbox_.take() && used) look(mailbox_.value(), any.sample.seq);
  }

  void look(const core::ProxySnapshot& proxy, std::uint64_t seq) {
    if (proxy.seq != seq || proxy.seq <= newest_) finding_ = "the sequence went back";
    newest_ = proxy.seq;
    if (proxy.born > now_) finding_ = "a proxy from the future";
    if (proxy.mode == core::ProxyMode::kNone) finding_ = "a sample without a mode";
    const auto n = proxy.x.size();
    if (n != kCoordinates && !(n == 0 && proxy.mode == core::ProxyMode::kFree)) {
      finding_ = "a position of a wrong size";
    }
    for (int i = 0; i < n; ++i) check(proxy.x[i], 1000.0);
    for (int p = 0; p < proxy.planes.offsets.size(); ++p) {
      check(proxy.planes.offsets[p], 1e9);
      for (int i = 0; i < kCoordinates; ++i) check(proxy.planes.normals(i, p), 1e6);
    }
  }
  void check(double value, double limit) {
    if (!(std::abs(value) <= limit)) finding_ = "a number that is not finite, or too large";
    if (std::fpclassify(value) == FP_SUBNORMAL) finding_ = "a subnormal number";
  }

  core::Mailbox<core::ProxySnapshot> mailbox_{};
  Ingress ingress_{mailbox_, kCoordinates};
  core::TimePoint now_{std::chrono::hours(1)};
  std::uint64_t calls_{0}, newest_{0};
  std::string finding_{};
};

std::vector<FuzzBytes> ingress_seeds() {
  // A lease of epoch 1, then samples: what, time (3), epoch, wide (0: one byte), seq, mode,
  // valid_for (8), size, values (5 x 8), planes.
  FuzzBytes begin{0, 0, 0, 10, 1, 50};
  std::vector<FuzzBytes> seeds;
  for (const std::uint8_t mode : FuzzBytes{1, 2, 3}) {
    FuzzBytes input = begin;
    for (std::uint8_t seq = 1; seq < 6; ++seq) {
      input.insert(input.end(), {99, 0, 39, 16, 1, 0, seq, mode});
      input.insert(input.end(), 8, 0);
      input.push_back(kCoordinates);
      for (int i = 0; i < kMostValues; ++i) {
        input.insert(input.end(), {0x3F, 0xB9, 0x99, 0x99, 0x99, 0x99, 0x99, 0x9A});  // 0.1
      }
      const std::uint8_t planes = mode == 3 ? 2 : 0;
      input.push_back(planes);
      for (int p = 0; p < planes; ++p) {
        for (int i = 0; i < kCoordinates; ++i) {
          input.insert(input.end(), {0x3F, 0xF0, 0, 0, 0, 0, 0, 0});  // 1
        }
        input.push_back(1);
        input.insert(input.end(), {0x40, 0x08, 0, 0, 0, 0, 0, 0});  // 3
      }
    }
    seeds.push_back(input);
  }
  return seeds;
}

}  // namespace

const FuzzTarget& ingress_target() {
  static const FuzzTarget kTarget{"ingress", [](FuzzInput input) { return Door().run(input); },
                                  ingress_seeds, 4096};
  return kTarget;
}

}  // namespace haptic::test
