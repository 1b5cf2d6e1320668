#include "worker/storage/export_files.h"

#include <filesystem>
#include <fstream>

#include "worker/storage/storage_error.h"

namespace granary::storage {

void make_directory(const Path& directory) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) throw StorageError(StorageFault::io, directory.string() + ": " + failure.message());
}

void write_text(const Path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw StorageError(StorageFault::io, path.string() + " cannot be written");
}

}  // namespace granary::storage
