// Meshes that a scene names by file become triangles of the scene, in the program that reads the
// scene from a file. From then on the scene carries all it needs; no path travels.
#pragma once

#include <string>

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"

namespace granary {

// Replaces chute.meshes by chute.triangles. Names are relative to the folder of `scene_file` ("-":
// the current one). Errors carry the field path.
Status inline_meshes(v1::Scene& scene, const std::string& scene_file);

}  // namespace granary
