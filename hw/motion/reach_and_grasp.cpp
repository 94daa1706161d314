#include "hw/motion/reach_and_grasp.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <string_view>

#include "haptic/core/error.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "hw/random.hpp"

namespace haptic::hw {
namespace {

constexpr double kPipLag = 0.040;  ///< PIP starts every movement this much after MCP, s

double between(std::mt19937_64& generator, double low, double high) {
  return low + (high - low) * uniform(generator);
}

/// One joint as a chain of minimum-jerk movements between still poses.
class Joint {
 public:
  explicit Joint(double rest) : from_(rest) {}
  void move(double start, double duration, double to) { moves_.push_back({start, duration, to}); }
  /// Asked for rising times only.
  [[nodiscard]] double at(double t) {
    while (next_ < moves_.size() && t >= moves_[next_].start + moves_[next_].duration) {
      from_ = moves_[next_++].to;
    }
    if (next_ == moves_.size()) return from_;
    const Move& move = moves_[next_];
    return from_ + (move.to - from_) * minimum_jerk((t - move.start) / move.duration);
  }

 private:
  struct Move {
    double start{0.0};
    double duration{0.0};
    double to{0.0};
  };
  std::vector<Move> moves_{};
  std::size_t next_{0};
  double from_;
};

/// A few sines of random frequency and phase in 8-12 Hz, with the wanted root mean square together.
class Tremor {
 public:
  Tremor(std::mt19937_64& generator, double rms)
      : amplitude_(rms * std::sqrt(2.0 / static_cast<double>(kSines))) {
    for (auto& [omega, phase] : sines_) {
      omega = 2.0 * std::numbers::pi * between(generator, 8.0, 12.0);
      phase = 2.0 * std::numbers::pi * uniform(generator);
    }
  }
  [[nodiscard]] double at(double t) const {
    double sum = 0.0;
    for (const auto& [omega, phase] : sines_) sum += std::sin(omega * t + phase);
    return amplitude_ * sum;
  }

 private:
  static constexpr std::size_t kSines = 5;
  struct Sine {
    double omega{0.0};
    double phase{0.0};
  };
  std::array<Sine, kSines> sines_{};
  double amplitude_;
};

struct Finger {
  Joint mcp;
  Joint pip;

  void move(double start, double duration, double mcp_to, double pip_to) {
    mcp.move(start, duration, mcp_to);
    pip.move(start + kPipLag, duration, pip_to);
  }
};

/// Where a movement goes, how long it takes, how long the finger then stays; rad, s.
struct Movement {
  double duration{0.0};
  double mcp{0.0};
  double pip{0.0};
  double stay{0.0};
};

constexpr double kRestMcp = 0.20, kRestPip = 0.25;

/// Reach (the hand opens), grasp and hold, release and pause.
std::array<Movement, 3> stroke(std::mt19937_64& g) {
  // Braces: drawn in the order in which they stand.
  const double speed = between(g, 0.8, 1.25);
  return {Movement{between(g, 0.35, 0.50) / speed, between(g, 0.02, 0.10), between(g, 0.10, 0.18),
                   between(g, 0.0, 0.1)},
          Movement{between(g, 0.55, 0.85) / speed, between(g, 0.75, 1.00), between(g, 0.90, 1.25),
                   between(g, 0.4, 0.9)},
          Movement{between(g, 0.50, 0.75) / speed, kRestMcp + between(g, -0.03, 0.03),
                   kRestPip + between(g, -0.03, 0.03), between(g, 0.3, 0.8)}};
}

/// As many whole strokes as fit in `seconds`: the motion ends as it began, at rest.
Finger strokes(std::mt19937_64& generator, double seconds) {
  Finger finger{Joint(kRestMcp), Joint(kRestPip)};
  double t = between(generator, 0.4, 0.8);
  for (;;) {
    const auto movements = stroke(generator);
    double length = 0.0;
    for (const Movement& m : movements) length += m.duration + kPipLag + m.stay;
    if (t + length > seconds) return finger;
    for (const Movement& m : movements) {
      finger.move(t, m.duration, m.mcp, m.pip);
      t += m.duration + kPipLag + m.stay;
    }
  }
}

void require_within(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw core::DeviceError(std::string(name) + " = " + std::to_string(value) + ": must lie within " +
                          std::to_string(low) + " and " + std::to_string(high));
}

}  // namespace

std::vector<JointAngles> make_reach_and_grasp(const ReachAndGrasp& options) {
  require_within("seconds", options.seconds, 1.0, 3600.0);
  require_within("rate", options.rate, 1.0, 1000.0);
  require_within("tremor_rms", options.tremor_rms, 0.0, 0.1);
  std::mt19937_64 generator(options.seed);
  const Tremor mcp_tremor(generator, options.tremor_rms);
  const Tremor pip_tremor(generator, options.tremor_rms);
  Finger finger = strokes(generator, options.seconds);
  const auto last = static_cast<std::int64_t>(std::floor(options.seconds * options.rate + 1e-9));
  std::vector<JointAngles> rows;
  rows.reserve(static_cast<std::size_t>(last) + 1);
  for (std::int64_t i = 0; i <= last; ++i) {
    const double t = static_cast<double>(i) / options.rate;
    rows.push_back({t, finger.mcp.at(t) + mcp_tremor.at(t), finger.pip.at(t) + pip_tremor.at(t)});
  }
  return rows;
}

void write_motion_csv(std::ostream& out, const std::vector<JointAngles>& rows) {
  const auto put = [&](double value, char end) {
    std::array<char, 32> text{};
    const auto [last, error] =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 6);
    static_cast<void>(error);  // an angle or a time within an hour fits by far
    out << std::string_view(text.data(), static_cast<std::size_t>(last - text.data())) << end;
  };
  out << "time_s,q_o1_mcp_rad,q_o2_pip_rad\n";
  for (const JointAngles& row : rows) {
    put(row.time, ',');
    put(row.mcp, ',');
    put(row.pip, '\n');
  }
}

}  // namespace haptic::hw
