// Sweeps: a fixed plan of scenes, a grid, a list or a Latin hypercube. The plan follows from the
// spec alone, so the only state is how much of it has been proposed.
#pragma once

#include "server/studies/study_generator.h"

namespace granary::server {

inline constexpr std::size_t kMaxSweepTrials = 100'000;

// Refuses unknown paths, values out of range and plans that are too large; every scene of plans up
// to 2,000 trials is validated here, so that nothing is queued when one of them is wrong.
Result<std::unique_ptr<StudyGenerator>> make_sweep(const v1::StudySpec& spec);

}  // namespace granary::server
