// Shipped scenes by name, resolved as the service resolves them.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "proto/contract/resolve.h"
#include "proto/contract/scene_meshes.h"
#include "proto/contract/scene_text.h"

namespace granary::tests {

inline v1::Scene shipped_scene(const std::string& name, const std::vector<FieldSetting>& set = {}) {
  const std::string path = std::string(GRANARY_SCENES) + "/" + name + ".txtpb";
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  Result<v1::Scene> scene = load_scene(text.str(), path, set);
  if (!scene) {
    ADD_FAILURE() << scene.error().message;
    return {};
  }
  if (const Status status = inline_meshes(*scene, path); !status) {
    ADD_FAILURE() << status.error().message;
  }
  const Result<ResolvedScene> resolved = resolve(*scene);
  if (!resolved) {
    ADD_FAILURE() << resolved.error().message;
    return *scene;
  }
  return resolved->scene;
}

}  // namespace granary::tests
