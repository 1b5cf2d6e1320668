// Result files by content: DATA/artifacts/ab/<sha256>. A file is received into incoming/, its
// checksum verified, fsynced and renamed, so a name that exists is always a whole file. Names come
// from checksums only: no text of a request ever becomes a path.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>

#include "proto/contract/result.h"
#include "proto/contract/sha256.h"

namespace granary::server {

struct ArtifactId {
  std::string sha256;
  std::uint64_t size_bytes = 0;
};

// A file being received. Removed by the destructor unless published.
class IncomingArtifact {
 public:
  IncomingArtifact(std::filesystem::path file, int descriptor);
  ~IncomingArtifact();
  IncomingArtifact(const IncomingArtifact&) = delete;
  IncomingArtifact& operator=(const IncomingArtifact&) = delete;

  Status append(std::string_view bytes);  // RESOURCE_EXHAUSTED when the disk is full

 private:
  friend class ArtifactStore;
  std::filesystem::path file_;
  int descriptor_;
  std::uint64_t size_bytes_ = 0;
  Sha256 hash_;
};

// Random access to a published file.
class ArtifactReader {
 public:
  explicit ArtifactReader(int descriptor) : descriptor_(descriptor) {}
  ~ArtifactReader();
  ArtifactReader(const ArtifactReader&) = delete;
  ArtifactReader& operator=(const ArtifactReader&) = delete;

  Result<std::string> read(std::uint64_t offset, std::size_t bytes) const;

 private:
  int descriptor_;
};

class ArtifactStore {
 public:
  // Creates the folders and removes what an earlier process left half received.
  explicit ArtifactStore(std::filesystem::path folder);

  Result<std::unique_ptr<IncomingArtifact>> receive();
  // DATA_LOSS when size or checksum differ from what the sender declared.
  Status publish(std::unique_ptr<IncomingArtifact> incoming, const ArtifactId& declared);
  Result<std::unique_ptr<ArtifactReader>> open(const std::string& sha256) const;
  // Removes published files that nothing refers to and that are older than `grace`: an upload is
  // published before the job that will refer to it. Returns how many.
  std::size_t sweep(const std::unordered_set<std::string>& referenced, std::chrono::seconds grace);
  Result<std::uint64_t> size_of(const std::string& sha256) const;  // NOT_FOUND

 private:
  std::filesystem::path path_of(const std::string& sha256) const;

  std::filesystem::path folder_;
};

}  // namespace granary::server
