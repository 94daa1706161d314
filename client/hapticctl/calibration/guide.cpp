#include "calibration/guide.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>

#include "google/protobuf/text_format.h"

namespace haptic::ctl {
namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

bool to_number(const std::string& text, double& value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() &&
         std::isfinite(value);
}

double range_of(const client::DegreeOfFreedom& dof) {
  return dof.upper - dof.lower;
}

/// The first result of `step`, which is tried up to Guide::kTries times.
template <typename Step>
auto tried(const std::string& failure, const Step& step) {
  for (int attempt = 0; attempt < Guide::kTries; ++attempt) {
    if (const auto result = step()) return *result;
  }
  throw CalibrationAborted(failure);
}

const std::string kAfterTries = " in " + std::to_string(Guide::kTries) + " tries";

}  // namespace

std::string Guide::answer() {
  std::string line;
  out_ << "> " << std::flush;
  if (!std::getline(in_, line)) throw CalibrationAborted("the answers ended");
  line = trimmed(line);
  if (line == "q") throw CalibrationAborted("given up");
  return line;
}

bool Guide::agrees(const std::string& question) {
  out_ << question << " [y/N]\n";
  const std::string said = answer();
  return said == "y" || said == "Y" || said == "yes";
}

std::optional<double> Guide::still(const Dof& dof, std::size_t index) {
  sensors_.begin();
  sensors_.pause(kStill);
  const Statistics seen = sensors_.end();
  if (seen.samples < kFewest || index >= seen.mean.size()) {
    out_ << "only " << seen.samples << " samples came in " << kStill
         << " s: is the device there?\n";
    return std::nullopt;
  }
  const double moved = seen.highest[index] - seen.lowest[index], most = kMostMotion * range_of(dof);
  if (moved <= most) return seen.mean[index];
  out_ << dof.name << " moved by " << moved << ' ' << dof.unit << ": hold it still, within " << most
       << ' ' << dof.unit << '\n';
  return std::nullopt;
}

Guide::Place Guide::place(const Dof& dof, std::size_t index, const char* which, double otherwise) {
  return tried(dof.name + ": no place was found" + kAfterTries, [&]() -> std::optional<Place> {
    out_ << "Bring " << dof.name << " to a " << which
         << " place that you know, hold it still, and say "
         << "where that is in " << dof.unit << " (Enter: " << otherwise
         << ", its end; q: give up)\n";
    const std::string said = answer();
    double truth = otherwise;
    if (!said.empty() && !to_number(said, truth)) {
      out_ << "'" << said << "' is no number\n";
      return std::nullopt;
    }
    const std::optional<double> reading = still(dof, index);
    return reading ? std::optional(Place{truth, *reading}) : std::nullopt;
  });
}

void Guide::travel(const Dof& dof, std::size_t index, v1::Calibration::Dof& found) {
  found = tried(dof.name + ": no travel was found" + kAfterTries,
                [&]() -> std::optional<v1::Calibration::Dof> {
                  out_ << "Move " << dof.name << " to both its ends and back, then press Enter\n";
                  sensors_.begin();
                  static_cast<void>(answer());
                  const Statistics seen = sensors_.end();
                  if (seen.samples == 0 || index >= seen.lowest.size()) {
                    out_ << "no samples came: is the device there?\n";
                    return std::nullopt;
                  }
                  const auto [lower, upper] =
                      std::minmax({found.scale() * seen.lowest[index] + found.offset(),
                                   found.scale() * seen.highest[index] + found.offset()});
                  const double margin = kBeyond * range_of(dof);
                  if (upper - lower < kLeastApart * range_of(dof)) {
                    out_ << "that were only " << upper - lower << ' ' << dof.unit << ", of "
                         << range_of(dof) << '\n';
                    return std::nullopt;
                  }
                  if (lower < dof.lower - margin || upper > dof.upper + margin) {
                    out_ << "that was " << lower << " to " << upper << ' ' << dof.unit
                         << ", the scene allows " << dof.lower << " to " << dof.upper
                         << ": were the two places right?\n";
                    return std::nullopt;
                  }
                  v1::Calibration::Dof moved = found;
                  moved.set_lower(lower);
                  moved.set_upper(upper);
                  return moved;
                });
}

v1::Calibration::Dof Guide::places(const Dof& dof, std::size_t index) {
  const std::string failure = dof.name + ": the two places were never far enough apart";
  return tried(failure, [&]() -> std::optional<v1::Calibration::Dof> {
    const Place first = place(dof, index, "first", dof.lower);
    const Place second = place(dof, index, "second", dof.upper);
    const double apart = second.truth - first.truth;
    const double read = second.reading - first.reading;
    // A sensor that hardly changes between two distant places is not connected to this DoF.
    if (std::abs(apart) < kLeastApart * range_of(dof) ||
        std::abs(read) < kMostMotion * range_of(dof)) {
      out_ << "the places are " << std::abs(apart) << ' ' << dof.unit << " apart and the readings "
           << std::abs(read) << ": both must differ, the places by " << kLeastApart * range_of(dof)
           << '\n';
      return std::nullopt;
    }
    const double scale = apart / read;
    v1::Calibration::Dof found;
    found.set_name(dof.name);
    found.set_scale(scale);
    found.set_offset(first.truth - scale * first.reading);
    return found;
  });
}

std::vector<double> Guide::force_zero() {
  // The motors go off before the hand lets go. With a wrong force zero, a free device at zero force
  // would drive to an end of its travel, press there with that error, and hold it once it is off.
  out_ << "Hold the device away from its ends and press Enter: its motors go off\n";
  static_cast<void>(answer());
  sensors_.switch_off();
  out_ << "Let go of the device so that nothing touches it, then press Enter\n";
  static_cast<void>(answer());
  sensors_.pause(kStill);
  sensors_.begin();
  sensors_.pause(kStill);
  return sensors_.end().force;
}

v1::Calibration Guide::run(const std::vector<Dof>& dofs) {
  v1::Calibration result;
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    *result.add_dof() = places(dofs[i], i);
    travel(dofs[i], i, *result.mutable_dof(static_cast<int>(i)));
  }
  for (const double zero : force_zero()) result.add_force_zero(zero);
  return result;
}

std::string to_textproto(const v1::Calibration& calibration) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(calibration, &text);
  return "# proto-file: haptic/v1/calibration.proto\n# proto-message: haptic.v1.Calibration\n"
         "# Written by hapticctl calibrate.\n" +
         text;
}

}  // namespace haptic::ctl
