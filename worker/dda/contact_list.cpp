#include "worker/dda/contact_list.h"

namespace granary::dda {

void ActiveContacts::reserve(std::size_t capacity) {
  if (first.size() >= capacity) return;
  for (auto* indices : {&first, &second, &slot}) indices->resize(capacity);
  for (auto* values : {&normal_x, &normal_y, &bias_n, &bias_t, &weight_n, &weight_t, &impulse_n,
                       &impulse_t, &gap_start, &stored_t, &gap_linear, &offset_t, &curvature,
                       &gap_now, &stick_t, &slide_t, &rebound, &drift_n, &drift_t})
    values->resize(capacity);
  group_rebounds.resize(capacity / kGroupSize + 1);
}

void ActiveContacts::reserve_rolling() {
  if (arm_first.size() == first.size()) return;
  for (auto* values : {&arm_first, &arm_second, &weight_r, &impulse_r, &rolled, &drift_r})
    values->resize(first.size());
}

}  // namespace granary::dda
