// What each effect contributes and costs: the base scene beside scenes that differ in one thing,
// with the same number of replicates; differences with their intervals, and the ratio of CPU
// seconds.
#pragma once

#include "server/studies/study_generator.h"

namespace granary::server {

// `ablate.effect` names effects (gas, rotating_frame, ...): on against off; or settings
// (path=value): the base scene against that value. None: every effect the scene's engine can
// switch. Figures of the summary: on|EFFECT (1 when the base scene has it, with the number and
// reason that decided), unavailable|EFFECT (the engine's words), relative|EFFECT|OBSERVABLE (delta
// / value).
Result<std::unique_ptr<StudyGenerator>> make_ablate(const v1::StudySpec& spec);

inline constexpr std::uint32_t kDefaultAblateReplicates = 6;

}  // namespace granary::server
