#include "client/session/link.h"

namespace granary::session {
namespace {

// Every chunk to `sink`, until it or the stream says no.
Status pass_on(grpc::ClientContext& context, grpc::ClientReader<v1::DownloadChunk>& reader,
               const ChunkSink& sink) {
  Status taken = Done{};
  v1::DownloadChunk chunk;
  while (taken && reader.Read(&chunk)) taken = sink(chunk);
  if (!taken) context.TryCancel();
  const grpc::Status status = reader.Finish();
  if (!taken) return taken;
  if (!status.ok()) return error_from(status);
  return Done{};
}

}  // namespace

Status Session::download(const std::string& name, std::uint64_t offset_bytes,
                         const ChunkSink& sink) {
  v1::DownloadRequest request;
  request.set_name(name);
  request.set_offset_bytes(offset_bytes);
  const auto context = link_->connection().stream_context();
  return pass_on(*context, *link_->connection().jobs().Download(context.get(), request), sink);
}

Status Session::backup(const ChunkSink& sink) {
  const auto context = link_->connection().stream_context();
  return pass_on(*context, *link_->connection().admin().Backup(context.get(), {}), sink);
}

}  // namespace granary::session
