#include "server/api/workers_service.h"

#include "server/api/download_stream.h"
#include "server/api/upload_stream.h"
#include "server/api/worker_stream.h"

namespace granary::server {

grpc::ServerBidiReactor<v1::WorkerMessage, v1::ServerMessage>* WorkersService::Synchronize(
    grpc::CallbackServerContext*) {
  return serve_worker(backend_);
}

grpc::ServerReadReactor<v1::UploadChunk>* WorkersService::Upload(grpc::CallbackServerContext*,
                                                                 v1::UploadResponse* response) {
  return receive_upload(backend_, response);
}

grpc::ServerWriteReactor<v1::DownloadChunk>* WorkersService::FetchArtifact(
    grpc::CallbackServerContext*, const v1::FetchArtifactRequest* request) {
  return send_artifact(backend_, [this, request]() -> Result<DownloadRange> {
    const auto task = task_id_from(request->task());
    if (!task || !backend_.dispatcher.holds(*task))
      return Error{ErrorCode::failed_precondition, "this task belongs to another execution now",
                   "task"};
    auto bytes = backend_.artifacts.size_of(request->sha256());
    if (!bytes) return bytes.error();
    return DownloadRange{{request->sha256(), *bytes}, 0, 0};
  });
}

grpc::ServerUnaryReactor* WorkersService::List(grpc::CallbackServerContext* context,
                                               const v1::ListWorkersRequest*,
                                               v1::ListWorkersResponse* response) {
  return look_on_owner(backend_, context, [this, response]() -> Status {
    for (v1::WorkerInfo& info : backend_.dispatcher.list_workers(system_now()))
      *response->add_workers() = std::move(info);
    return Done{};
  });
}

}  // namespace granary::server
