// One Upload call: a file from the worker that holds a task, into the artifact store.
#pragma once

#include <grpcpp/grpcpp.h>

#include "granary/v1/worker.pb.h"
#include "server/api/backend.h"

namespace granary::server {

grpc::ServerReadReactor<v1::UploadChunk>* receive_upload(Backend& backend,
                                                         v1::UploadResponse* response);

}  // namespace granary::server
