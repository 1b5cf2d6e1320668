#include "worker/run/task_setup.h"

#include <unistd.h>

#include "proto/contract/resolve.h"
#include "proto/contract/version.h"

namespace granary::run {
namespace {

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace

Result<TaskSpec> make_task(const v1::Scene& submitted, const EngineBuild& build) {
  Result<ResolvedScene> resolved = resolve(submitted);
  if (!resolved) return resolved.error();
  TaskSpec spec;
  spec.scene_key = job_key(resolved->scene);
  spec.filling_key = filling_key(resolved->scene);
  spec.scene = std::move(resolved->scene);
  spec.engine_version = kEngineVersion;
  spec.vector_path = build.vector_path;
  spec.host = host_name();
  spec.decisions = std::move(resolved->decisions);
  spec.effects = std::move(resolved->effects);
  spec.warnings = std::move(resolved->warnings);
  return spec;
}

}  // namespace granary::run
