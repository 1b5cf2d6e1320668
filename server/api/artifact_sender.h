// Streams a range of one file to whoever asked. Created at the start of the call; whoever finds the file
// calls send() or refuse(), once, from any thread. Deletes itself at the end of the call.
#pragma once

#include <memory>

#include <grpcpp/grpcpp.h>

#include "granary/v1/job.pb.h"
#include "server/artifacts/artifact_store.h"

namespace granary::server {

struct DownloadRange {
  ArtifactId artifact;
  std::uint64_t offset_bytes = 0;
  std::uint64_t limit_bytes = 0;  // 0 = to the end
};

class ArtifactSender : public grpc::ServerWriteReactor<v1::DownloadChunk> {
 public:
  void send(std::unique_ptr<ArtifactReader> reader, const DownloadRange& range);
  void refuse(const grpc::Status& status) { Finish(status); }

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void send_next();

  std::unique_ptr<ArtifactReader> reader_;
  v1::DownloadChunk chunk_;
  std::uint64_t offset_ = 0, end_ = 0;
  bool started_ = false;
};

}  // namespace granary::server
