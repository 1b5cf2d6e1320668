#include "worker/dem/trouble.h"

#include <string>
#include <utility>

namespace granary::dem {

core::Rejection not_a_number(double time, std::vector<std::int64_t> ids) {
  return {time, "position or velocity is not a number", std::move(ids),
          "a smaller chute.time_step_s", core::Cause::not_finite};
}

core::Rejection path_too_long(double time, double path_ratio, std::vector<std::int64_t> ids) {
  return {time, "path of " + std::to_string(path_ratio) + " radii in one step", std::move(ids),
          "a smaller chute.time_step_s", core::Cause::speed};
}

core::Rejection overlap_too_deep(double time, double overlap_ratio, std::vector<std::int64_t> ids) {
  return {time, "overlap of " + std::to_string(overlap_ratio) + " radii", std::move(ids),
          "a larger chute.contact_pp.normal_stiffness_n_per_m (walls: contact_pw), or a smaller "
          "chute.time_step_s",
          core::Cause::overlap};
}

}  // namespace granary::dem
