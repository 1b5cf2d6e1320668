#include "server/api/download_stream.h"

#include <memory>

namespace granary::server {
namespace {

void open_and_send(Backend& backend, const Result<DownloadRange>& range, ArtifactSender* sender) {
  if (!range.ok()) return sender->refuse(to_grpc(range.error()));
  auto reader = backend.artifacts.open(range->artifact.sha256);
  if (!reader) return sender->refuse(to_grpc(reader.error()));
  sender->send(std::move(*reader), *range);
}

}  // namespace

grpc::ServerWriteReactor<v1::DownloadChunk>* send_artifact(
    Backend& backend, std::function<Result<DownloadRange>()> find) {
  auto* sender = new ArtifactSender;
  auto range = std::make_shared<Result<DownloadRange>>(Error{});
  backend.owner.read([range, find = std::move(find)] { *range = find(); },
                     [&backend, range, sender](const Status& committed) {
                       if (!committed.ok()) return sender->refuse(to_grpc(committed));
                       open_and_send(backend, *range, sender);
                     });
  return sender;
}

}  // namespace granary::server
