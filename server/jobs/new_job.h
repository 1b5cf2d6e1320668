// From a scene to a job that can be queued: validated, resolved, keyed.
#pragma once

#include "granary/v1/scene.pb.h"
#include "proto/contract/result.h"
#include "server/jobs/records.h"

namespace granary::server {

// Everything of a NewJob that follows from its scene. INVALID_ARGUMENT with the field path.
Result<NewJob> new_job_of(const v1::Scene& scene);

}  // namespace granary::server
