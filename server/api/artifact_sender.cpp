#include "server/api/artifact_sender.h"

#include <algorithm>

#include "server/api/backend.h"

namespace granary::server {
namespace {

constexpr std::uint64_t kChunkBytes = 1 << 20;  // 1 GB/s on loopback; larger gains nothing

}  // namespace

void ArtifactSender::send(std::unique_ptr<ArtifactReader> reader, const DownloadRange& range) {
  if (range.offset_bytes > range.artifact.size_bytes)
    return Finish({grpc::StatusCode::OUT_OF_RANGE, "offset_bytes is beyond the end of the file"});
  reader_ = std::move(reader);
  offset_ = range.offset_bytes;
  end_ = range.artifact.size_bytes;
  if (range.limit_bytes > 0) end_ = std::min(end_, offset_ + range.limit_bytes);
  chunk_.mutable_artifact()->set_sha256(range.artifact.sha256);
  chunk_.mutable_artifact()->set_size_bytes(range.artifact.size_bytes);
  chunk_.set_offset_bytes(offset_);
  if (offset_ < end_) return send_next();
  started_ = true;  // nothing left to send, but the client learns size and checksum
  StartWrite(&chunk_);
}

void ArtifactSender::OnWriteDone(bool ok) {
  if (!ok) return Finish(grpc::Status::CANCELLED);
  send_next();
}

void ArtifactSender::send_next() {
  if (offset_ == end_) return Finish(grpc::Status::OK);
  auto bytes = reader_->read(offset_, std::min(kChunkBytes, end_ - offset_));
  if (!bytes) return Finish(to_grpc(bytes.error()));
  if (bytes->empty())
    return Finish({grpc::StatusCode::DATA_LOSS, "the stored file is shorter than recorded"});
  if (started_) chunk_.clear_artifact();
  started_ = true;
  chunk_.set_offset_bytes(offset_);
  offset_ += bytes->size();
  chunk_.set_data(std::move(*bytes));
  StartWrite(&chunk_);
}

}  // namespace granary::server
