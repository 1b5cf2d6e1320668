// granary.v1.Workers.
#pragma once

#include "granary/v1/worker.grpc.pb.h"
#include "server/api/backend.h"

namespace granary::server {

class WorkersService : public v1::Workers::CallbackService {
 public:
  explicit WorkersService(Backend& backend) : backend_(backend) {}

  grpc::ServerBidiReactor<v1::WorkerMessage, v1::ServerMessage>* Synchronize(
      grpc::CallbackServerContext*) override;
  grpc::ServerReadReactor<v1::UploadChunk>* Upload(grpc::CallbackServerContext*,
                                                   v1::UploadResponse*) override;
  grpc::ServerWriteReactor<v1::DownloadChunk>* FetchArtifact(
      grpc::CallbackServerContext*, const v1::FetchArtifactRequest*) override;
  grpc::ServerUnaryReactor* List(grpc::CallbackServerContext*, const v1::ListWorkersRequest*,
                                 v1::ListWorkersResponse*) override;

 private:
  Backend& backend_;
};

}  // namespace granary::server
