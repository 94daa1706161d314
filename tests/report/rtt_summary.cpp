#include "tests/report/rtt_summary.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>

#include "haptic/core/error.hpp"
#include "tests/report/csv.hpp"

namespace haptic::report {
namespace {

constexpr double kMilli = 1e3;
using Objects = std::vector<std::string>;  // names, or how they begin

const Objects kMasses{"rigid_", "soft_", "stiffening", "disc_", "moving_", "two_fingers"};
const Objects kTold{"rigid_",  "soft_",       "stiffening", "disc_",
                    "moving_", "two_fingers", "finger_",    "pushed_right"};
const Objects kLinear{"rigid_wall", "soft_wall"};
const Objects kRight{"rigid_wall", "soft_wall", "two_fingers",
                     "pushed_right"};  // their laws are told right

bool of(const std::string& name, const Objects& objects) {
  return std::any_of(objects.begin(), objects.end(),
                     [&](const std::string& o) { return name.rfind(o, 0) == 0; });
}

double percent(const RttRow& row) {
  return row.shadow.percent();
}

struct Claim {
  std::string what{};
  Objects objects{};  ///< none: all
  double limit{0.0};
  std::string unit{"%"};
  double from_s{0.0}, to_s{0.2};  ///< round trips
  std::function<double(const RttRow&)> figure{percent};
  bool lost{false};  ///< with samples lost
  RttPeer peer{RttPeer::kContacts};
};

/// Errors, without loss.
std::vector<Claim> errors() {
  return {
      {"linear soft and rigid objects", kLinear, 1.0},
      {"linear soft and rigid objects", kLinear, 0.05, "N", 0.0, 0.2,
       [](const RttRow& row) { return row.shadow.error; }},
      {"soft finger along recorded grasps", {"finger_"}, 1.0},
      {"soft finger, shadow behind the same tank",
       {"finger_"},
       1.0,
       "%",
       0.0,
       0.2,
       [](const RttRow& row) { return 100.0 * row.behind_tank / row.shadow.peak; }},
      {"stiffening, one contact", {"stiffening"}, 4.0, "%", 0.0, 0.1},
      {"stiffening, one contact", {"stiffening"}, 8.0, "%", 0.2, 0.2},
      {"disc of 30 mm at up to 70 mm/s", {"disc_70mm_s"}, 3.0, "%", 0.0, 0.1},
      {"disc of 30 mm at up to 70 mm/s", {"disc_70mm_s"}, 8.0, "%", 0.2, 0.2},
      {"moved by itself", {"moving_"}, 2.0},
      {"pushed, law told right", {"pushed_right"}, 2.0},
      {"pushed, with a disturbance", {"pushed_disturbed"}, 2.0},
      {"pushed, law wrong by 2", {"pushed_wrong"}, 5.0},
      {"two fingers on one object", {"two_fingers"}, 5.0},
      {"proxies only, estimator", kLinear, 12.0, "%", 0.0, 0.05, percent, false,
       RttPeer::kEstimated},
  };
}

std::vector<Claim> claims() {
  std::vector<Claim> all = errors();
  for (Claim claim : errors()) {
    claim.what += ", loss 10 %";
    claim.limit *= 1.5;
    claim.lost = true;
    all.push_back(std::move(claim));
  }
  const auto energy = [](const RttRow& row) { return row.energy_mj; };
  all.push_back({"energy, law told right", kRight, 2.0, "mJ", 0.0, 0.2, energy});
  all.push_back({"energy, soft finger", {"finger_"}, 2.0, "mJ", 0.0, 0.2, energy});
  all.push_back({"held back, law told right, no delay", kRight, 0.0, "% of contact", 0.0, 0.0,
                 [](const RttRow& row) { return 100.0 * row.shadow.held_back; }});
  const auto drag = [](const RttRow& row) { return row.shadow.drag; };
  all.push_back({"drag in free space, masses", kMasses, 0.0, "N", 0.0, 0.2, drag});
  all.push_back({"drag in free space, soft finger", {"finger_"}, 0.0, "N", 0.0, 0.2, drag});
  all.push_back({"onset late", kTold, 1.0, "ticks", 0.0, 0.2,
                 [](const RttRow& row) { return static_cast<double>(row.shadow.onset); }});
  return all;
}

}  // namespace

void write_summary(const std::vector<RttRow>& rows, const std::string& file) {
  constexpr double kSame = 1e-9;  // s
  std::ofstream out(file);
  out << "claim,round_trips_ms,limit,unit,worst,where,verdict\n";
  for (const Claim& claim : claims()) {
    const RttRow* worst = nullptr;
    for (const RttRow& row : rows) {
      if (row.how.peer != claim.peer) continue;
      // What is pushed is shown with every rate.
      if (row.how.rate_hz != 60.0 && row.object.rfind("pushed", 0) != 0) continue;
      if ((row.how.lost > 0.0) != claim.lost) continue;
      if (!claim.objects.empty() && !of(row.object, claim.objects)) continue;
      if (row.how.round_trip_s < claim.from_s - kSame) continue;
      if (row.how.round_trip_s > claim.to_s + kSame) continue;
      if (worst == nullptr || claim.figure(row) > claim.figure(*worst)) worst = &row;
    }
    const std::string span = claim.from_s == claim.to_s
                                 ? cell(kMilli * claim.to_s)
                                 : cell(kMilli * claim.from_s) + " to " + cell(kMilli * claim.to_s);
    if (worst == nullptr) {
      out << line_of(claim.what, span, claim.limit, claim.unit, "", "", "not shown") << '\n';
      continue;
    }
    const double figure = claim.figure(*worst);
    out << line_of(claim.what, span, claim.limit, claim.unit, figure,
                   worst->object + " at " + cell(kMilli * worst->how.round_trip_s) + " ms",
                   figure <= claim.limit ? "met" : "not met")
        << '\n';
  }
  out.flush();
  if (!out) throw core::SceneError("rtt: cannot write " + file);
}

}  // namespace haptic::report
