// Trials as messages of the API: the study's record joined with its job and values.
#pragma once

#include "granary/v1/study.pb.h"
#include "server/jobs/job_store.h"
#include "server/studies/study_records.h"

namespace granary::server {

v1::Trial to_message(const TrialRecord& trial, JobStore& jobs);

}  // namespace granary::server
