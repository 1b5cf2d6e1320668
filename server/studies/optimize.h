// Optimizations: a search method proposes points, each point becomes a candidate with one run or
// more, and what the runs say decides what the method proposes next. Constraints, noise, coarse
// runs and the budget are dealt with here, once for all methods.
#pragma once

#include "server/studies/study_generator.h"

namespace granary::server {

inline constexpr std::uint32_t kMaxOptimizeTrials = 100'000;

Result<std::unique_ptr<StudyGenerator>> make_optimize(const v1::StudySpec& spec);

}  // namespace granary::server
