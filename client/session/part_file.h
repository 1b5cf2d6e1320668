// The growing FILE.part of a download: written in place, synced, then renamed by its owner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "proto/contract/result.h"

namespace granary::session {

std::filesystem::path with_suffix(const std::filesystem::path& file, const char* suffix);

class PartFile {
 public:
  static Result<PartFile> open(const std::filesystem::path& path);  // created, or as it was left
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();

  std::uint64_t size_bytes() const;
  Status write_at(std::uint64_t offset_bytes, std::string_view bytes);
  Status empty();
  Status sync();
  const std::filesystem::path& path() const { return path_; }

 private:
  PartFile(int fd, std::filesystem::path path) : fd_(fd), path_(std::move(path)) {}
  int fd_;
  std::filesystem::path path_;
};

}  // namespace granary::session
