#include "server/artifacts/artifact_store.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::server {
namespace {

Error io_error(const std::string& what) {
  const ErrorCode code =
      errno == ENOSPC || errno == EDQUOT ? ErrorCode::resource_exhausted : ErrorCode::internal;
  return {code, what + ": " + std::strerror(errno), ""};
}

// A rename is durable only when the folder that holds the name is.
Status sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return io_error("cannot open the artifact folder");
  const int outcome = ::fsync(descriptor);
  ::close(descriptor);
  if (outcome != 0) return io_error("cannot sync the artifact folder");
  return Done{};
}

}  // namespace

IncomingArtifact::IncomingArtifact(std::filesystem::path file, int descriptor)
    : file_(std::move(file)), descriptor_(descriptor) {}

IncomingArtifact::~IncomingArtifact() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!file_.empty()) ::unlink(file_.c_str());
}

Status IncomingArtifact::append(std::string_view bytes) {
  hash_.update(bytes);
  size_bytes_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return io_error("cannot store the upload");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return Done{};
}

ArtifactReader::~ArtifactReader() {
  ::close(descriptor_);
}

Result<std::string> ArtifactReader::read(std::uint64_t offset, std::size_t bytes) const {
  std::string buffer(bytes, '\0');
  std::size_t have = 0;
  while (have < bytes) {
    const ssize_t got =
        ::pread(descriptor_, buffer.data() + have, bytes - have, static_cast<off_t>(offset + have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return io_error("cannot read the artifact");
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  buffer.resize(have);
  return buffer;
}

ArtifactStore::ArtifactStore(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
  std::filesystem::remove_all(folder_ / "incoming");
  std::filesystem::create_directories(folder_ / "incoming");
}

std::filesystem::path ArtifactStore::path_of(const std::string& sha256) const {
  return folder_ / sha256.substr(0, 2) / sha256;
}

Result<std::uint64_t> ArtifactStore::size_of(const std::string& sha256) const {
  std::error_code error;
  const std::uint64_t bytes =
      is_sha256_hex(sha256) ? std::filesystem::file_size(path_of(sha256), error) : 0;
  if (!is_sha256_hex(sha256) || error)
    return Error{ErrorCode::not_found, "there is no such artifact", "sha256"};
  return bytes;
}

Result<std::unique_ptr<IncomingArtifact>> ArtifactStore::receive() {
  std::string name = (folder_ / "incoming" / "XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) return io_error("cannot create an incoming file");
  return std::make_unique<IncomingArtifact>(name, descriptor);
}

Status ArtifactStore::publish(std::unique_ptr<IncomingArtifact> incoming,
                              const ArtifactId& declared) {
  if (!is_sha256_hex(declared.sha256))
    return Error{ErrorCode::invalid_argument, "artifact.sha256 must be 64 hex digits",
                 "artifact.sha256"};
  if (incoming->size_bytes_ != declared.size_bytes || incoming->hash_.hex() != declared.sha256)
    return Error{ErrorCode::data_loss, "the upload is not what its checksum says",
                 "artifact.sha256"};
  if (::fsync(incoming->descriptor_) != 0) return io_error("cannot sync the upload");
  const std::filesystem::path target = path_of(declared.sha256);
  std::error_code error;
  std::filesystem::create_directories(target.parent_path(), error);
  if (::rename(incoming->file_.c_str(), target.c_str()) != 0)
    return io_error("cannot publish the upload");
  incoming->file_.clear();
  if (Status status = sync_folder(target.parent_path()); !status) return status;
  return sync_folder(folder_);
}

Result<std::unique_ptr<ArtifactReader>> ArtifactStore::open(const std::string& sha256) const {
  if (!is_sha256_hex(sha256)) return Error{ErrorCode::not_found, "there is no result file", ""};
  const int descriptor = ::open(path_of(sha256).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Error{ErrorCode::not_found, "the result file is gone", ""};
  return std::make_unique<ArtifactReader>(descriptor);
}

std::size_t ArtifactStore::sweep(const std::unordered_set<std::string>& referenced,
                                 std::chrono::seconds grace) {
  std::size_t removed = 0;
  std::error_code error;
  const auto newest = std::filesystem::file_time_type::clock::now() - grace;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (!is_sha256_hex(name) || referenced.count(name) > 0) continue;
    if (entry.last_write_time(error) > newest || error) continue;
    removed += std::filesystem::remove(entry.path(), error);
  }
  return removed;
}

}  // namespace granary::server
