// From the scene as written to the scene as run: every default filled in, every "chosen" setting
// and every AUTO effect decided, each with who chose it and on what evidence. The server keys jobs
// on the resolved scene, the worker runs it, `granary check` prints it: one function, one answer.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "granary/v1/result.pb.h"
#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

struct ResolvedScene {
  v1::Scene scene;
  std::vector<v1::Decision> decisions;
  std::map<std::string, v1::EffectReport> effects;
  std::vector<std::string> warnings;
};

// INVALID_ARGUMENT with the field path when the scene is not valid (scene_rules.h).
Result<ResolvedScene> resolve(const v1::Scene& scene);

// SHA-256 (hex) over engine version and every set field of a resolved scene except those that
// cannot change the physics: name, threads, output. Independent of how the scene was written.
std::string job_key(const v1::Scene& resolved);

// The same over what decides the filling only; empty for scenes without one.
std::string filling_key(const v1::Scene& resolved);

}  // namespace granary
