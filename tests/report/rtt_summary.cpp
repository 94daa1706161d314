#include "tests/report/rtt_summary.hpp"

#include <algorithm>
#include <fstream>

#include "haptic/core/error.hpp"
#include "tests/report/csv.hpp"

namespace haptic::report {
namespace {

constexpr double kMilli = 1e3;
using Objects = std::vector<std::string>;  // names; "x_*": all that begin so

const Objects kMasses{"rigid_*", "soft_*", "stiffening*", "disc_*", "moving_*", "two_fingers"};
const Objects kTold{"rigid_*",  "soft_*",      "stiffening*", "disc_*",
                    "moving_*", "two_fingers", "finger_*",    "pushed_right_*"};
const Objects kLinear{"rigid_wall", "soft_wall*"};
const Objects kRight{"rigid_wall", "soft_wall*", "two_fingers", "pushed_right_*",
                     "sliding_right_*"};  // their laws are told right
const Objects kFinger{"finger_*"};

bool of(const std::string& name, const Objects& objects) {
  return std::any_of(objects.begin(), objects.end(), [&](const std::string& o) {
    return o.back() == '*' ? name.starts_with(o.substr(0, o.size() - 1)) : name == o;
  });
}

double percent(const RttRow& row) {
  return row.figures.shadow.percent();
}

/// Share of what the bound's median may be: 5 times the error's, or 1 % of the peak.
double slack_used(const RttRow& row) {
  const ShadowFigures& bound = row.figures.bound;
  return bound.bound_median / std::max(5.0 * bound.error_median, 0.01 * bound.peak);
}

double error(const RttRow& row) {
  return row.figures.shadow.error;
}
double broken(const RttRow& row) {
  return 100.0 * (1.0 - row.figures.bound.kept);
}
double energy(const RttRow& row) {
  return row.energy_mj;
}
double held_back(const RttRow& row) {
  return 100.0 * row.figures.shadow.held_back;
}
double drag(const RttRow& row) {
  return row.figures.shadow.drag;
}
double onset(const RttRow& row) {
  return static_cast<double>(row.figures.shadow.onset);
}

struct Claim {
  std::string what{};
  Objects objects{};  ///< none: all
  double limit{0.0};
  double from_s{0.0}, to_s{0.2};  ///< round trips
  double (*figure)(const RttRow&){percent};
  std::string unit{"%"};
  RttPeer peer{RttPeer::kContacts};
  bool lost{false};  ///< with samples lost
};

/// Errors, without loss.
std::vector<Claim> errors() {
  const std::string stiffening = "stiffening, one contact", disc = "disc of 30 mm at up to 70 mm/s";
  const std::string pushed = "pushed, mass wrong by 2", sliding = "sliding, mass wrong by 2";
  return {
      {"linear soft and rigid objects", kLinear, 1.0},
      {"linear soft and rigid objects", kLinear, 0.05, 0.0, 0.2, error, "N"},
      {"soft finger along recorded grasps", kFinger, 1.0},
      {stiffening, {"stiffening"}, 4.0, 0.0, 0.1},
      {stiffening, {"stiffening"}, 8.0, 0.2, 0.2},
      {disc, {"disc_70mm_s"}, 3.0, 0.0, 0.1},
      {disc, {"disc_70mm_s"}, 8.0, 0.2, 0.2},
      {"moved by itself", {"moving_*"}, 2.0},
      {"pushed, law told right", {"pushed_right_*", "sliding_right_*"}, 2.0},
      {"pushed, with a disturbance", {"pushed_disturbed_*"}, 2.0},
      {pushed, {"pushed_wrong_*"}, 5.0, 0.0, 0.1},
      {pushed, {"pushed_wrong_*"}, 5.0, 0.2, 0.2},
      {sliding, {"sliding_wrong_*"}, 5.0, 0.0, 0.02},
      {sliding, {"sliding_wrong_*"}, 5.0, 0.05, 0.2},
      {"two fingers on one object", {"two_fingers*"}, 5.0},
  };
}

/// The contacts that a session derives from proxies alone.
Claim estimated(const std::string& what, const Objects& objects) {
  return {"proxies only, estimator, " + what,
          objects,
          12.0,
          0.0,
          0.05,
          percent,
          "%",
          RttPeer::kEstimated};
}

std::vector<Claim> claims() {
  std::vector<Claim> all = errors();
  all.push_back(estimated("soft wall", {"soft_wall"}));
  all.push_back(estimated("rigid wall or 2 Hz", {"rigid_wall", "soft_wall_2hz"}));
  for (Claim claim : errors()) {
    claim.what += ", loss 10 %";
    claim.limit *= 1.5;
    claim.lost = true;
    all.push_back(std::move(claim));
  }
  const std::string ticks = "% of ticks", used = "of 5 errors or 1 %", contact = "% of contact";
  const Objects flat{"rigid_wall", "soft_wall*", "two_fingers"};
  const Objects curved{"disc_70mm_s", "finger_worn_*"};
  const std::vector<Claim> others{
      {"bound broken", {}, 0.0, 0.0, 0.2, broken, ticks},
      {"bound broken, loss 10 %", {}, 0.0, 0.0, 0.2, broken, ticks, RttPeer::kContacts, true},
      {"bound's median, walls and block", flat, 1.0, 0.0, 0.2, slack_used, used},
      {"bound's median, curved", curved, 1.0, 0.0, 0.05, slack_used, used},
      {"bound's median, curved", curved, 1.0, 0.1, 0.2, slack_used, used},
      {"energy, law told right", kRight, 2.0, 0.0, 0.2, energy, "mJ"},
      {"energy, soft finger", kFinger, 2.0, 0.0, 0.2, energy, "mJ"},
      {"held back, law told right, no delay", kRight, 0.0, 0.0, 0.0, held_back, contact},
      {"held back, soft finger, no delay", kFinger, 0.0, 0.0, 0.0, held_back, contact},
      {"drag in free space, masses", kMasses, 0.0, 0.0, 0.2, drag, "N"},
      {"drag in free space, soft finger", kFinger, 0.0, 0.0, 0.2, drag, "N"},
      {"onset late", kTold, 1.0, 0.0, 0.2, onset, "ticks"},
  };
  all.insert(all.end(), others.begin(), others.end());
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
      // Objects that are pushed are shown with every rate.
      if (row.how.rate_hz != 60.0 && !of(row.object, {"pushed_*", "sliding_*"})) continue;
      if ((row.how.lost > 0.0) != claim.lost) continue;
      if (!claim.objects.empty() && !of(row.object, claim.objects)) continue;
      if (row.how.round_trip_s < claim.from_s - kSame) continue;
      if (row.how.round_trip_s > claim.to_s + kSame) continue;
      if (worst == nullptr || claim.figure(row) > claim.figure(*worst)) worst = &row;
    }
    const std::string span = claim.from_s == claim.to_s
                                 ? cell(kMilli * claim.to_s)
                                 : cell(kMilli * claim.from_s) + " to " + cell(kMilli * claim.to_s);
    const Line head = line_of(claim.what, span, claim.limit, claim.unit);
    if (worst == nullptr) {
      out << line_of(head, "", "", "not shown").text << '\n';
      continue;
    }
    const double figure = claim.figure(*worst);
    out << line_of(head, figure,
                   worst->object + " at " + cell(kMilli * worst->how.round_trip_s) + " ms",
                   figure <= claim.limit ? "met" : "not met")
               .text
        << '\n';
  }
  out.flush();
  if (!out) throw core::SceneError("rtt: cannot write " + file);
}

}  // namespace haptic::report
