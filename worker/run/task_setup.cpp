#include "worker/run/task_setup.h"

#include <unistd.h>

#include <cstdlib>

#include "proto/contract/resolve.h"
#include "proto/contract/version.h"

namespace granary::run {
namespace {

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

// Operators lengthen it where disks are slow; tests shorten it.
double checkpoint_interval_s(double otherwise_s) {
  const char* text = std::getenv("GRANARY_CHECKPOINT_INTERVAL_S");
  char* end = nullptr;
  const double seconds = text == nullptr ? -1 : std::strtod(text, &end);
  return end != nullptr && end != text && seconds >= 0 ? seconds : otherwise_s;
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
  spec.checkpoint_interval_s = checkpoint_interval_s(spec.checkpoint_interval_s);
  spec.decisions = std::move(resolved->decisions);
  spec.effects = std::move(resolved->effects);
  spec.warnings = std::move(resolved->warnings);
  return spec;
}

}  // namespace granary::run
