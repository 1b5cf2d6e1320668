#include "client/session/file_checksum.h"

#include <fstream>
#include <vector>

#include "proto/contract/sha256.h"

namespace granary::session {

Result<std::string> sha256_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::not_found, path.string() + " cannot be opened", ""};
  Sha256 digest;
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    digest.update(block.data(), static_cast<std::size_t>(file.gcount()));
  if (file.bad()) return Error{ErrorCode::data_loss, path.string() + " cannot be read", ""};
  return digest.hex();
}

}  // namespace granary::session
