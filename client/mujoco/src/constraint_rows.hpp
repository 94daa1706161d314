#pragma once
/// Rows of MuJoCo's constraints, as the last mj_forward or mj_step found them.

#include <mujoco/mujoco.h>

#include <cstddef>

namespace haptic::mujoco {

[[nodiscard]] inline bool is_contact(int type) {
  return type == mjCNSTR_CONTACT_FRICTIONLESS || type == mjCNSTR_CONTACT_PYRAMIDAL ||
         type == mjCNSTR_CONTACT_ELLIPTIC;
}

/// Calls f(dof, value) for each entry of a row's J.
template <typename Each>
void for_parts(const mjModel& model, const mjData& data, int row, Each each) {
  const bool sparse = mj_isSparse(&model) != 0;
  const auto begin = sparse ? static_cast<std::size_t>(data.efc_J_rowadr[row])
                            : static_cast<std::size_t>(row) * static_cast<std::size_t>(model.nv);
  const int count = sparse ? data.efc_J_rownnz[row] : model.nv;
  for (int k = 0; k < count; ++k) {
    const std::size_t at = begin + static_cast<std::size_t>(k);
    if (data.efc_J[at] != 0.0) each(sparse ? data.efc_J_colind[at] : k, data.efc_J[at]);
  }
}

}  // namespace haptic::mujoco
