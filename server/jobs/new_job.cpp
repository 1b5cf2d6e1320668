#include "server/jobs/new_job.h"

#include "proto/contract/resolve.h"
#include "proto/contract/scene_rules.h"

namespace granary::server {

Result<NewJob> new_job_of(const v1::Scene& scene) {
  auto resolved = resolve(scene);
  if (!resolved) return resolved.error();
  NewJob job;
  job.kind = kind_of(scene);
  job.scene_bytes = scene.SerializeAsString();
  job.resolved_bytes = resolved->scene.SerializeAsString();
  job.key = job_key(resolved->scene);
  job.filling_key = filling_key(resolved->scene);
  job.wants_stored_filling = resolved->scene.discharge().filling() == v1::Discharge::STORED;
  return job;
}

}  // namespace granary::server
