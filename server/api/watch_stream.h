// One Watch call: a Watcher on the owner thread's side, a write reactor on gRPC's side.
#pragma once

#include <memory>

#include <grpcpp/grpcpp.h>

#include "granary/v1/job.pb.h"
#include "server/api/backend.h"

namespace granary::server {

grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Backend& backend,
                                                  const v1::WatchJobRequest& request);

}  // namespace granary::server
