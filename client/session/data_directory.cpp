#include "client/session/data_directory.h"

#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "proto/contract/sha256.h"

namespace granary::session {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSocketName = "granaryd.sock";

// A directory in /tmp may have been made by somebody else, who would then hear our requests.
Status make_own_directory(const fs::path& path) {
  if (mkdir(path.c_str(), 0700) == 0) return Done{};
  struct stat facts {};
  if (errno == EEXIST && lstat(path.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) &&
      facts.st_uid == getuid() && (facts.st_mode & 0077) == 0)
    return Done{};
  return Error{ErrorCode::permission_denied,
               path.string() + " is not a directory of this user alone (mode 0700)", ""};
}

}  // namespace

fs::path socket_path(const fs::path& data_directory, uid_t user) {
  const fs::path usual = data_directory / kSocketName;
  if (usual.string().size() < sizeof(sockaddr_un::sun_path)) return usual;
  const std::string hash = sha256_hex(data_directory.string()).substr(0, 16);
  return fs::path("/tmp") / ("granary-" + std::to_string(user) + "-" + hash) / kSocketName;
}

Result<DataDirectory> DataDirectory::open(const fs::path& path) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(path, failure).lexically_normal();
  if (!fs::exists(absolute, failure) && fs::create_directories(absolute, failure))
    fs::permissions(absolute, fs::perms::owner_all, failure);
  if (access(absolute.c_str(), W_OK | X_OK) != 0)
    return Error{ErrorCode::permission_denied,
                 "data directory " + absolute.string() + ": " + std::strerror(errno), ""};
  return DataDirectory(absolute);
}

fs::path DataDirectory::worker_directory(int number) const {
  return path_ / "workers" / std::to_string(number);
}

Result<std::string> DataDirectory::socket_address() const {
  const fs::path path = socket_path(path_, getuid());
  if (path.parent_path() != path_)
    if (auto own = make_own_directory(path.parent_path()); !own) return own.error();
  return "unix:" + path.string();
}

std::string DataDirectory::server_address() const {
  std::string address;
  std::ifstream file(address_file());
  if (std::getline(file, address) && !address.empty()) return address;
  return "unix:" + socket_path(path_, getuid()).string();
}

Status DataDirectory::write_server_address(const std::string& address) const {
  std::ofstream file(address_file());
  file << address << "\n";
  file.close();
  if (!file)
    return Error{ErrorCode::permission_denied, address_file().string() + " cannot be written", ""};
  return Done{};
}

void DataDirectory::forget_server() const {
  std::error_code failure;
  fs::remove(address_file(), failure);
  const fs::path socket = socket_path(path_, getuid());
  if (socket.parent_path() == path_) return;
  fs::remove(socket, failure);
  fs::remove(socket.parent_path(), failure);
}

}  // namespace granary::session
