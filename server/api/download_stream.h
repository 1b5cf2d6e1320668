// Artifact bytes to a client or worker, in order, from any offset.
#pragma once

#include <functional>

#include "server/api/artifact_sender.h"
#include "server/api/backend.h"

namespace granary::server {

// `find` runs on the owner thread and says what to send.
grpc::ServerWriteReactor<v1::DownloadChunk>* send_artifact(
    Backend& backend, std::function<Result<DownloadRange>()> find);

}  // namespace granary::server
