#include "calibration/guide.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>

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

std::string shortest(double value) {
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, value);
  return {text, result.ptr};
}

double range_of(const SensedDof& dof) {
  return dof.upper - dof.lower;
}

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

bool Guide::still(const SensedDof& dof, std::size_t index, double& reading) {
  sensors_.begin();
  sensors_.pause(kStill);
  const Statistics seen = sensors_.end();
  if (seen.samples < kFewest || index >= seen.mean.size()) {
    out_ << "only " << seen.samples << " samples came in " << kStill
         << " s: is the device there?\n";
    return false;
  }
  const double moved = seen.highest[index] - seen.lowest[index];
  if (moved > kMostMotion * range_of(dof)) {
    out_ << dof.name << " moved by " << moved << ' ' << dof.unit << ": hold it still, within "
         << kMostMotion * range_of(dof) << ' ' << dof.unit << '\n';
    return false;
  }
  reading = seen.mean[index];
  return true;
}

Guide::Place Guide::place(const SensedDof& dof, std::size_t index, const char* which,
                          double otherwise) {
  for (int attempt = 0; attempt < kTries; ++attempt) {
    out_ << "Bring " << dof.name << " to a " << which
         << " place that you know, hold it still, and say "
         << "where that is in " << dof.unit << " (Enter: " << shortest(otherwise)
         << ", its end; q: give up)\n";
    const std::string said = answer();
    Place place;
    place.truth = otherwise;
    if (!said.empty() && !to_number(said, place.truth)) {
      out_ << "'" << said << "' is no number\n";
      continue;
    }
    if (still(dof, index, place.reading)) return place;
  }
  throw CalibrationAborted(dof.name + ": no place was found in " + std::to_string(kTries) +
                           " tries");
}

void Guide::travel(const SensedDof& dof, std::size_t index, DofCalibration& found) {
  for (int attempt = 0; attempt < kTries; ++attempt) {
    out_ << "Move " << dof.name << " to both its ends and back, then press Enter\n";
    sensors_.begin();
    static_cast<void>(answer());
    const Statistics seen = sensors_.end();
    if (seen.samples == 0 || index >= seen.lowest.size()) {
      out_ << "no samples came: is the device there?\n";
      continue;
    }
    const double a = found.scale * seen.lowest[index] + found.offset;
    const double b = found.scale * seen.highest[index] + found.offset;
    found.lower = std::min(a, b);
    found.upper = std::max(a, b);
    const double margin = kBeyond * range_of(dof);
    if (found.upper - found.lower < kLeastApart * range_of(dof)) {
      out_ << "that were only " << found.upper - found.lower << ' ' << dof.unit << ", of "
           << range_of(dof) << '\n';
    } else if (found.lower < dof.lower - margin || found.upper > dof.upper + margin) {
      out_ << "that was " << found.lower << " to " << found.upper << ' ' << dof.unit
           << ", the scene allows " << dof.lower << " to " << dof.upper
           << ": were the two places right?\n";
    } else {
      return;
    }
  }
  throw CalibrationAborted(dof.name + ": no travel was found in " + std::to_string(kTries) +
                           " tries");
}

DofCalibration Guide::one(const SensedDof& dof, std::size_t index) {
  DofCalibration found;
  found.name = dof.name;
  for (int attempt = 0;; ++attempt) {
    if (attempt == kTries) {
      throw CalibrationAborted(dof.name + ": the two places were never far enough apart");
    }
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
      continue;
    }
    found.scale = apart / read;
    found.offset = first.truth - found.scale * first.reading;
    break;
  }
  travel(dof, index, found);
  return found;
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

CalibrationResult Guide::run(const std::vector<SensedDof>& dofs) {
  CalibrationResult result;
  for (std::size_t i = 0; i < dofs.size(); ++i) result.dofs.push_back(one(dofs[i], i));
  result.force_zero = force_zero();
  return result;
}

std::string to_textproto(const CalibrationResult& result, const std::string& serial,
                         const std::string& date) {
  std::string escaped;
  for (const char c : serial) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c;
  }
  std::string text =
      "# proto-file: haptic/v1/calibration.proto\n# proto-message: haptic.v1.Calibration\n"
      "# Written by hapticctl calibrate.\ndevice_serial: \"" +
      escaped + "\"\ndate: \"" + date + "\"\n";
  for (const DofCalibration& dof : result.dofs) {
    text += "dof { name: \"" + dof.name + "\" scale: " + shortest(dof.scale) +
            " offset: " + shortest(dof.offset) + " lower: " + shortest(dof.lower) +
            " upper: " + shortest(dof.upper) + " }\n";
  }
  for (const double zero : result.force_zero) text += "force_zero: " + shortest(zero) + "\n";
  return text;
}

}  // namespace haptic::ctl
