#include "worker/agent/upload.h"

#include <grpcpp/grpcpp.h>

#include <fstream>
#include <vector>

#include "proto/contract/sha256.h"

namespace granary::agent {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

Result<v1::Artifact> describe(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return Error{ErrorCode::data_loss, "the engine left no " + file.filename().string(), ""};
  Sha256 hash;
  v1::Artifact artifact;
  std::vector<char> buffer(kChunkBytes);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), in.gcount() > 0) {
    hash.update(buffer.data(), static_cast<std::size_t>(in.gcount()));
    artifact.set_size_bytes(artifact.size_bytes() + static_cast<std::uint64_t>(in.gcount()));
  }
  artifact.set_sha256(hash.hex());
  return artifact;
}

}  // namespace

Result<v1::Artifact> upload_file(const ServerPeer& server, const UploadTask& task,
                                 const std::filesystem::path& file) {
  auto artifact = describe(file);
  if (!artifact) return artifact.error();
  const auto context = server.context();
  v1::UploadResponse response;
  auto writer = server.stub().Upload(context.get(), &response);
  v1::UploadChunk chunk;
  chunk.mutable_header()->set_task(task.task);
  chunk.mutable_header()->set_fencing_token(task.fencing_token);
  chunk.mutable_header()->set_purpose(task.purpose);
  *chunk.mutable_header()->mutable_artifact() = *artifact;
  std::ifstream in(file, std::ios::binary);
  std::string buffer(kChunkBytes, '\0');
  bool going = true;
  while (going &&
         (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), in.gcount() > 0)) {
    chunk.set_data(buffer.data(), static_cast<std::size_t>(in.gcount()));
    going = writer->Write(chunk);
    chunk.clear_header();
  }
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  if (!status.ok())
    return Error{static_cast<ErrorCode>(status.error_code()), status.error_message(), ""};
  return response.artifact();
}

}  // namespace granary::agent
