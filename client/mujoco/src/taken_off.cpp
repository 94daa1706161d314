#include "taken_off.hpp"

#include <algorithm>

namespace haptic::mujoco {

namespace {

bool moves_joint(const mjModel& model, const BoundTool& tool, int joint) {
  return tool.coupled().moves(model.jnt_dofadr[joint]);
}

/// True if a tendon goes round a joint that the device moves, or over a body that it moves.
bool moves_tendon(const mjModel& model, const BoundTool& tool, int tendon) {
  const int first = model.tendon_adr[tendon], end = first + model.tendon_num[tendon];
  for (int i = first; i < end; ++i) {
    const int type = model.wrap_type[i], id = model.wrap_objid[i];
    if (type == mjWRAP_JOINT && moves_joint(model, tool, id)) return true;
    if (type == mjWRAP_SITE && tool.moves(model.site_bodyid[id])) return true;
  }
  return false;
}

bool moves_actuator(const mjModel& model, const BoundTool& tool, int actuator) {
  const int id = model.actuator_trnid[2 * actuator];
  switch (model.actuator_trntype[actuator]) {
    case mjTRN_JOINT:
    case mjTRN_JOINTINPARENT:
      return moves_joint(model, tool, id);
    case mjTRN_TENDON:
      return moves_tendon(model, tool, id);
    case mjTRN_SITE:
    case mjTRN_SLIDERCRANK:
      return tool.moves(model.site_bodyid[id]);
    default:
      return false;
  }
}

std::string actuator_name(const mjModel& model, int actuator) {
  if (const char* const name = mj_id2name(&model, mjOBJ_ACTUATOR, actuator); name != nullptr) {
    return "'" + std::string(name) + "'";
  }
  const int type = model.actuator_trntype[actuator], id = model.actuator_trnid[2 * actuator];
  const char* const joint = type == mjTRN_JOINT ? mj_id2name(&model, mjOBJ_JOINT, id) : nullptr;
  return joint != nullptr ? "that of joint '" + std::string(joint) + "'"
                          : "number " + std::to_string(actuator);
}

}  // namespace

void take_off_limits(mjModel& model, const BoundTool& tool) {
  const CoupledDofs& coupled = tool.coupled();
  for (int dof = 0; dof < model.nv; ++dof) {
    if (!coupled.bound(dof) && !coupled.led(dof)) continue;
    model.jnt_limited[model.dof_jntid[dof]] = 0;
    model.dof_frictionloss[dof] = 0.0;
  }
  for (int tendon = 0; tendon < model.ntendon; ++tendon) {
    if (moves_tendon(model, tool, tendon)) model.tendon_frictionloss[tendon] = 0.0;
  }
}

std::string take_off_actuators(mjModel& model, const BoundTool& tool) {
  std::string names;
  for (int i = 0; i < model.nu; ++i) {
    if (!moves_actuator(model, tool, i)) continue;
    if (!names.empty()) names += ", ";
    names += actuator_name(model, i);
    model.actuator_gaintype[i] = mjGAIN_FIXED;
    model.actuator_biastype[i] = mjBIAS_NONE;
    std::fill_n(model.actuator_gainprm + mjNGAIN * i, mjNGAIN, 0.0);
  }
  return names;
}

}  // namespace haptic::mujoco
