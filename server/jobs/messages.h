// What the queue says to workers and watchers, made from its records. Pure: no clock, no store.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/jobs/records.h"
#include "server/workers/worker_registry.h"

namespace granary::server {

v1::JobEvent to_event(const EventRecord& record);
StoredArtifact to_stored(const v1::Artifact& artifact);

v1::ServerMessage welcome_message();
v1::ServerMessage cancel_message(TaskId task, const std::string& reason);
// Stop and forget this task: somebody else's now, or nobody's.
v1::ServerMessage drop_message(TaskId task);
v1::ServerMessage acknowledged_message(TaskId task);
// The present execution of `job`, with what lets it continue or start from a stored filling.
v1::ServerMessage assignment_message(const JobRecord& job,
                                     const std::vector<ResumeFileRecord>& resume_files,
                                     const std::optional<StoredArtifact>& filling);

// Without the busy slots and tasks, which the leases know.
v1::WorkerInfo worker_info(const std::string& id, const Worker& worker, Now now);
WorkerRecord worker_record(const std::string& id, const Worker& worker, Now now);

}  // namespace granary::server
