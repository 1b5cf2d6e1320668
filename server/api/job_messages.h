// Records of the queue as messages of the API.
#pragma once

#include "granary/v1/job.pb.h"
#include "proto/contract/result.h"
#include "server/jobs/records.h"

namespace granary::server {

v1::Job to_message(const JobRecord& job);

// Validates, resolves and keys a submitted scene. INVALID_ARGUMENT with the field path.
Result<NewJob> to_new_job(const v1::SubmitJobsRequest::Item& item, const std::string& owner);

}  // namespace granary::server
