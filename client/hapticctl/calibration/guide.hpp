#pragma once
/// The guided calibration. It asks a person to bring every DoF to two known places, to move it
/// through its whole travel, and to let go; from this it computes what the readings mean. It reads
/// answers from one stream and writes questions to another, so that a script can answer.
///
///   per DoF    two places    q = scale reading + offset
///              whole travel  lower, upper
///   last       hands off     force_zero; the motors go off before the hands

#include <iosfwd>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "calibration/sensors.hpp"
#include "haptic/client/types.hpp"
#include "haptic/v1/calibration.pb.h"

namespace haptic::ctl {

/// The person gave up ("q", or the answers ended), or a step failed too often.
class CalibrationAborted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Guide {
 public:
  static constexpr double kStill = 1.0;         ///< s over which a place is averaged
  static constexpr int kTries = 5;              ///< of one step
  static constexpr double kMostMotion = 0.01;   ///< of the DoF's range, while it is held still
  static constexpr double kLeastApart = 0.2;    ///< of the range: the two places, and the travel
  static constexpr double kBeyond = 0.05;       ///< of the range: how far travel may leave it
  static constexpr std::uint64_t kFewest = 50;  ///< samples of a place

  Guide(Sensors& sensors, std::istream& answers, std::ostream& questions)
      : sensors_(sensors), in_(answers), out_(questions) {}

  /// The DoFs and force_zero of a calibration. Throws CalibrationAborted.
  [[nodiscard]] v1::Calibration run(const std::vector<client::DegreeOfFreedom>& dofs);
  /// True if the person answers "y".
  [[nodiscard]] bool agrees(const std::string& question);

 private:
  struct Place {
    double truth{0.0}, reading{0.0};
  };
  using Dof = client::DegreeOfFreedom;
  /// A DoF in two places that are far enough apart, or moved through its travel, or in one place;
  /// each asks up to kTries times.
  [[nodiscard]] v1::Calibration::Dof places(const Dof& dof, std::size_t index);
  void travel(const Dof& dof, std::size_t index, v1::Calibration::Dof& found);
  [[nodiscard]] Place place(const Dof& dof, std::size_t index, const char* which, double otherwise);
  /// The reading of a DoF that is held still; nothing if it moved.
  [[nodiscard]] std::optional<double> still(const Dof& dof, std::size_t index);
  [[nodiscard]] std::vector<double> force_zero();
  [[nodiscard]] std::string answer();

  Sensors& sensors_;
  std::istream& in_;
  std::ostream& out_;
};

/// The file that hapticd reads; numbers read back to the same bits.
[[nodiscard]] std::string to_textproto(const v1::Calibration& calibration);

}  // namespace haptic::ctl
