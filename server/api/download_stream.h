// Artifact bytes to a client or worker, in order, from any offset.
#pragma once

#include <functional>

#include <grpcpp/grpcpp.h>

#include "granary/v1/job.pb.h"
#include "server/api/backend.h"

namespace granary::server {

struct DownloadRange {
  ArtifactId artifact;
  std::uint64_t offset_bytes = 0;
  std::uint64_t limit_bytes = 0;  // 0 = to the end
};

// `find` runs on the owner thread and says what to send.
grpc::ServerWriteReactor<v1::DownloadChunk>* send_artifact(
    Backend& backend, std::function<Result<DownloadRange>()> find);

}  // namespace granary::server
