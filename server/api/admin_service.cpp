#include "server/api/admin_service.h"

#include <fcntl.h>

#include "server/store/backup.h"

namespace granary::server {
namespace {

struct BackupFile {
  std::unique_ptr<ArtifactReader> reader;
  ArtifactId id;
};

Result<BackupFile> open_without_name(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(file, error);
  std::filesystem::remove(file, error);  // lives as long as somebody reads it
  if (descriptor < 0) return Error{ErrorCode::internal, "the backup cannot be read", ""};
  BackupFile made{std::make_unique<ArtifactReader>(descriptor), {"", bytes}};
  Sha256 hash;
  for (std::uint64_t offset = 0; offset < bytes; offset += 1 << 20) {
    auto part = made.reader->read(offset, 1 << 20);
    if (!part) return part.error();
    hash.update(*part);
  }
  made.id.sha256 = hash.hex();
  return made;
}

// In the folder of incoming files, which a start empties: a kill leaves nothing behind for long.
Result<BackupFile> make_backup(const std::filesystem::path& data) {
  const std::filesystem::path file = data / "artifacts" / "incoming" / "backup.db";
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  try {
    copy_database(data / "granary.db", file);
  } catch (const std::exception& failure) {
    std::filesystem::remove(file, ignored);
    return Error{ErrorCode::resource_exhausted, std::string("the backup failed: ") + failure.what(), ""};
  }
  return open_without_name(file);
}

}  // namespace

AdminService::~AdminService() {
  if (thread_.joinable()) thread_.join();
}

grpc::ServerWriteReactor<v1::DownloadChunk>* AdminService::Backup(grpc::CallbackServerContext*,
                                                                  const v1::BackupRequest*) {
  backend_.touch();
  auto* sender = new ArtifactSender;
  std::lock_guard lock(mutex_);
  if (busy_) {
    sender->refuse({grpc::StatusCode::RESOURCE_EXHAUSTED, "another backup is being made, try again later"});
    return sender;
  }
  busy_ = true;
  if (thread_.joinable()) thread_.join();
  thread_ = std::thread([this, sender] { make_and_send(sender); });
  return sender;
}

void AdminService::make_and_send(ArtifactSender* sender) {
  auto made = make_backup(data_);
  if (made)
    sender->send(std::move(made->reader), {made->id, 0, 0});
  else
    sender->refuse(to_grpc(made.error()));
  std::lock_guard lock(mutex_);
  busy_ = false;
}

}  // namespace granary::server
