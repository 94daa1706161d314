#include "server/scene/calibration_scene.hpp"

#include <fstream>
#include <sstream>

#include "haptic/v1/calibration.pb.h"
#include "server/scene/text_format.hpp"

namespace haptic::server {
namespace {

/// "2026-11-21": a form, not a calendar.
bool is_date(const std::string& text) {
  if (text.size() != 10) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool dash = i == 4 || i == 7;
    if (dash ? text[i] != '-' : (text[i] < '0' || text[i] > '9')) return false;
  }
  return true;
}

/// Fills in DoF number `i` of the kinematics; why it cannot, or nothing.
std::string take_dof(const v1::Calibration& message, const core::DofSpec& dof, Eigen::Index i,
                     hw::board::Calibration& calibration) {
  const v1::Calibration::Dof* found = nullptr;
  for (const v1::Calibration::Dof& entry : message.dof()) {
    if (entry.name() != dof.name) continue;
    if (found != nullptr) return "has DoF '" + dof.name + "' twice";
    found = &entry;
  }
  if (found == nullptr) return "lacks DoF '" + dof.name + "'";
  calibration.scale[i] = found->scale();
  calibration.offset[i] = found->offset();
  calibration.lower[i] = found->lower();
  calibration.upper[i] = found->upper();
  return {};
}

}  // namespace

std::optional<hw::board::Calibration> read_calibration(const std::filesystem::path& file,
                                                       const std::string& path,
                                                       const core::Kinematics* kinematics,
                                                       Problems& problems) {
  const std::size_t before = problems.count();
  const auto wrong = [&](const std::string& why) {
    problems.wrong(path, quoted(file.string()), why);
  };
  std::ifstream stream(file);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  v1::Calibration message;
  if (!stream) {
    wrong("must be a file of hapticctl calibrate; it cannot be read");
  } else if (const std::string found = parse_fragment(text.str(), message); !found.empty()) {
    wrong("must be a file of hapticctl calibrate: " + found);
  }
  if (problems.count() > before || kinematics == nullptr) return std::nullopt;

  hw::board::Calibration calibration;
  calibration.source = file.string();
  calibration.serial = message.device_serial();
  calibration.date = message.date();
  if (calibration.serial.empty()) wrong("device_serial: is required");
  if (!is_date(calibration.date))
    wrong("date = " + server::quoted(calibration.date) + ": must be YYYY-MM-DD");
  const auto& dofs = kinematics->dofs();
  const auto n_q = static_cast<Eigen::Index>(dofs.size());
  for (core::VecQ* list :
       {&calibration.scale, &calibration.offset, &calibration.lower, &calibration.upper}) {
    list->setZero(n_q);
  }
  if (message.dof_size() > n_q) {
    wrong("has " + std::to_string(message.dof_size()) + " DoFs; must have " + std::to_string(n_q));
  }
  for (Eigen::Index i = 0; i < n_q; ++i) {
    const std::string found = take_dof(message, dofs[static_cast<std::size_t>(i)], i, calibration);
    if (!found.empty()) wrong(found);
  }
  if (message.force_zero_size() > core::kMaxQ) {
    wrong("has " + std::to_string(message.force_zero_size()) + " zeros of force");
  } else {
    calibration.force_zero.resize(message.force_zero_size());
    for (int i = 0; i < message.force_zero_size(); ++i) {
      calibration.force_zero[i] = message.force_zero(i);
    }
  }
  if (problems.count() > before) return std::nullopt;
  return calibration;
}

}  // namespace haptic::server
