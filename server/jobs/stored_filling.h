// discharge.filling STORED: the job starts from the filling of another job, named in
// discharge.stored_filling. Settled at submission, so that a wrong name never waits in the queue.
#pragma once

#include "proto/contract/result.h"
#include "server/jobs/job_store.h"

namespace granary::server {

// Gives a job with filling STORED the filling key of the job it names, and a key of its own that
// depends on that filling and not on the name. Errors name the field: INVALID_ARGUMENT (no job
// name; the other job fills another bucket or has nothing to share), NOT_FOUND, FAILED_PRECONDITION
// (not stored yet, or by another engine version).
Status take_stored_filling(JobStore& store, NewJob& job);

}  // namespace granary::server
