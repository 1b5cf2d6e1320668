#include "server/api/upload_stream.h"

#include <memory>

namespace granary::server {
namespace {

constexpr std::uint64_t kMaxArtifactBytes = 64ull << 30;

class UploadReactor : public grpc::ServerReadReactor<v1::UploadChunk> {
 public:
  UploadReactor(Backend& backend, v1::UploadResponse* response)
      : backend_(backend), response_(response) {
    StartRead(&chunk_);
  }

  void OnReadDone(bool ok) override {
    if (!incoming_)
      return ok ? begin()
                : Finish({grpc::StatusCode::INVALID_ARGUMENT, "an upload starts with a header"});
    if (!ok) return publish();
    append();
  }
  void OnDone() override { delete this; }

 private:
  // The fencing token decides: only the present holder of the task may deliver.
  void begin() {
    const auto task = task_id_from(chunk_.header().task());
    if (!chunk_.has_header() || !task)
      return Finish({grpc::StatusCode::INVALID_ARGUMENT, "an upload starts with a header"});
    if (chunk_.header().artifact().size_bytes() > kMaxArtifactBytes)
      return Finish({grpc::StatusCode::INVALID_ARGUMENT, "artifact.size_bytes is beyond 64 GiB"});
    auto held = std::make_shared<bool>(false);
    backend_.owner.post([this, held, task = *task] { *held = backend_.dispatcher.holds(task); },
                        [this, held](const Status& committed) {
                          if (!committed.ok()) return Finish(to_grpc(committed));
                          if (!*held)
                            return Finish({grpc::StatusCode::FAILED_PRECONDITION,
                                           "this task belongs to another execution now"});
                          receive();
                        });
  }

  void receive() {
    declared_ = {chunk_.header().artifact().sha256(), chunk_.header().artifact().size_bytes()};
    auto incoming = backend_.artifacts.receive();
    if (!incoming) return Finish(to_grpc(incoming.error()));
    incoming_ = std::move(*incoming);
    append();
  }

  void append() {
    received_ += chunk_.data().size();
    if (received_ > declared_.size_bytes)
      return Finish({grpc::StatusCode::INVALID_ARGUMENT, "more bytes than declared"});
    if (Status status = incoming_->append(chunk_.data()); !status) return Finish(to_grpc(status));
    chunk_.Clear();
    StartRead(&chunk_);
  }

  void publish() {
    Status status = backend_.artifacts.publish(std::move(incoming_), declared_);
    if (!status) return Finish(to_grpc(status));
    response_->mutable_artifact()->set_sha256(declared_.sha256);
    response_->mutable_artifact()->set_size_bytes(declared_.size_bytes);
    Finish(grpc::Status::OK);
  }

  Backend& backend_;
  v1::UploadResponse* response_;
  v1::UploadChunk chunk_;
  std::unique_ptr<IncomingArtifact> incoming_;
  ArtifactId declared_;
  std::uint64_t received_ = 0;
};

}  // namespace

grpc::ServerReadReactor<v1::UploadChunk>* receive_upload(Backend& backend,
                                                         v1::UploadResponse* response) {
  return new UploadReactor(backend, response);
}

}  // namespace granary::server
