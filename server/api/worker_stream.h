// One Synchronize stream: what the worker says goes to the owner thread, what it is told comes from
// there through a WorkerLink.
#pragma once

#include <grpcpp/grpcpp.h>

#include "granary/v1/worker.pb.h"
#include "server/api/backend.h"

namespace granary::server {

grpc::ServerBidiReactor<v1::WorkerMessage, v1::ServerMessage>* serve_worker(Backend& backend);

}  // namespace granary::server
