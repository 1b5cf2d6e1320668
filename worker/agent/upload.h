// Sends one file to the artifact store of the server.
#pragma once

#include <filesystem>
#include <string>

#include "granary/v1/worker.grpc.pb.h"
#include "proto/contract/result.h"
#include "worker/agent/server_peer.h"

namespace granary::agent {

struct UploadTask {
  std::string task;
  std::uint64_t fencing_token = 0;
  v1::UploadChunk::Purpose purpose = v1::UploadChunk::RESULT;
};

// One try. UNAVAILABLE may be tried again; FAILED_PRECONDITION means the task is not ours any more.
Result<v1::Artifact> upload_file(const ServerPeer& server, const UploadTask& task,
                                 const std::filesystem::path& file);

}  // namespace granary::agent
