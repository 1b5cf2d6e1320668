#include "client/session/link.h"

namespace granary::session {

Status Session::download(const std::string& name, std::uint64_t offset_bytes,
                         const ChunkSink& sink) {
  v1::DownloadRequest request;
  request.set_name(name);
  request.set_offset_bytes(offset_bytes);
  const auto context = link_->connection().stream_context();
  const auto reader = link_->connection().jobs().Download(context.get(), request);
  Status taken = Done{};
  v1::DownloadChunk chunk;
  while (taken && reader->Read(&chunk)) taken = sink(chunk);
  if (!taken) context->TryCancel();
  const grpc::Status status = reader->Finish();
  if (!taken) return taken;
  if (!status.ok()) return error_from(status);
  return Done{};
}

}  // namespace granary::session
