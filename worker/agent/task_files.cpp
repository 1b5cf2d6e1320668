#include "worker/agent/task_files.h"

#include <grpcpp/grpcpp.h>
#include <spdlog/spdlog.h>

#include <fstream>

#include "proto/contract/sha256.h"
#include "worker/agent/upload.h"

namespace granary::agent {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCheckpoint = "checkpoint";
constexpr const char* kFillingIn = "filling.in";
constexpr const char* kFillingOut = "filling.out";

bool is_sealed_segment(const std::string& name) {
  return name.rfind("segment-", 0) == 0 && name.find(".open") == std::string::npos &&
         name.find(".tmp") == std::string::npos;
}

}  // namespace

TaskFiles::TaskFiles(const v1::TaskAssignment& assignment, fs::path folder,
                     const ServerPeer& server, Send send)
    : assignment_(assignment), folder_(std::move(folder)), server_(server), send_(std::move(send)) {}

void TaskFiles::fetch() {
  for (const v1::ResumeFile& file : assignment_.resume_files()) {
    if (fetch_one(file.artifact(), file.name())) continue;
    // Half a checkpoint is none: start over.
    for (const v1::ResumeFile& each : assignment_.resume_files()) {
      std::error_code ignored;
      fs::remove(folder_ / each.name(), ignored);
    }
    break;
  }
  if (assignment_.has_filling()) filling_shared_ = fetch_one(assignment_.filling(), kFillingIn);
}

bool TaskFiles::fetch_one(const v1::Artifact& artifact, const std::string& name) {
  const auto context = server_.context();
  v1::FetchArtifactRequest request;
  request.set_task(assignment_.task());
  request.set_fencing_token(assignment_.fencing_token());
  request.set_sha256(artifact.sha256());
  auto reader = server_.stub().FetchArtifact(context.get(), request);
  const fs::path file = folder_ / name;
  std::ofstream out(file, std::ios::binary);
  Sha256 hash;
  v1::DownloadChunk chunk;
  while (reader->Read(&chunk)) {
    hash.update(chunk.data());
    out.write(chunk.data().data(), static_cast<std::streamsize>(chunk.data().size()));
  }
  const grpc::Status status = reader->Finish();
  if (status.ok() && out.flush() && hash.hex() == artifact.sha256()) return true;
  spdlog::warn("event=fetch_failed task={} file={} reason=\"{}\"", assignment_.task(), name,
               status.ok() ? "damaged on the way" : status.error_message());
  std::error_code ignored;
  fs::remove(file, ignored);
  return false;
}

void TaskFiles::share() {
  share_filling();
  share_checkpoint();
}

// A hard link pins the content while the engine may already be replacing the name.
bool TaskFiles::upload_pinned(const std::string& name, v1::UploadChunk::Purpose purpose,
                              v1::Artifact* artifact) {
  const fs::path pinned = folder_ / ("upload." + name);
  std::error_code error;
  fs::remove(pinned, error);
  fs::create_hard_link(folder_ / name, pinned, error);
  if (error) return false;
  auto uploaded =
      upload_file(server_, {assignment_.task(), assignment_.fencing_token(), purpose}, pinned);
  fs::remove(pinned, error);
  if (!uploaded) {
    spdlog::warn("event=share_failed task={} file={} reason=\"{}\"", assignment_.task(), name,
                 uploaded.error().message);
    return false;
  }
  *artifact = *uploaded;
  return true;
}

void TaskFiles::share_filling() {
  if (filling_shared_ || assignment_.filling_key().empty()) return;
  if (!fs::exists(folder_ / kFillingOut)) return;
  v1::WorkerMessage message;
  v1::FillingStored& stored = *message.mutable_filling_stored();
  if (!upload_pinned(kFillingOut, v1::UploadChunk::FILLING, stored.mutable_artifact())) return;
  stored.set_task(assignment_.task());
  stored.set_fencing_token(assignment_.fencing_token());
  stored.set_filling_key(assignment_.filling_key());
  send_(message);
  filling_shared_ = true;
}

void TaskFiles::share_checkpoint() {
  std::error_code error;
  const auto time = fs::last_write_time(folder_ / kCheckpoint, error);
  if (error || time == checkpoint_time_) return;
  v1::WorkerMessage message;
  v1::TaskCheckpointed& checkpointed = *message.mutable_checkpointed();
  checkpointed.set_task(assignment_.task());
  checkpointed.set_fencing_token(assignment_.fencing_token());
  // The checkpoint first: the segments it lists were sealed before it was written.
  v1::ResumeFile& checkpoint = *checkpointed.add_files();
  checkpoint.set_name(kCheckpoint);
  if (!upload_pinned(kCheckpoint, v1::UploadChunk::CHECKPOINT, checkpoint.mutable_artifact()))
    return;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (!is_sealed_segment(name)) continue;
    const auto known = shared_segments_.find(name);
    if (known == shared_segments_.end() &&
        !upload_pinned(name, v1::UploadChunk::CHECKPOINT, &shared_segments_[name])) {
      shared_segments_.erase(name);
      return;
    }
    v1::ResumeFile& segment = *checkpointed.add_files();
    segment.set_name(name);
    *segment.mutable_artifact() = shared_segments_[name];
  }
  send_(message);
  checkpoint_time_ = time;
}

}  // namespace granary::agent
