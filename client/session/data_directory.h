// Where a server and its clients on this machine meet: names inside a data directory.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

#include "proto/contract/result.h"

namespace granary::session {

class DataDirectory {
 public:
  // Creates the directory (0700) if need be. `path` may be relative.
  static Result<DataDirectory> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  // Held by a client while it looks for or starts the private server.
  std::filesystem::path start_lock() const { return path_ / "start.lock"; }
  // Held by the one `granary up` of this directory for its whole life.
  std::filesystem::path supervisor_lock() const { return path_ / "supervisor.lock"; }
  std::filesystem::path private_log() const { return path_ / "private.log"; }
  std::filesystem::path worker_directory(int number) const;

  // Where the server of this directory listens: what its supervisor wrote down, else the socket.
  std::string server_address() const;
  Status write_server_address(const std::string& address) const;
  // After the server has left: its address, and the short socket directory.
  void forget_server() const;

  // unix:PATH of the socket of this directory. sun_path holds 107 characters: the socket of a
  // directory with a longer name lies in /tmp/granary-UID-HASH, which is ours alone (0700).
  Result<std::string> socket_address() const;

 private:
  explicit DataDirectory(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path address_file() const { return path_ / "server.address"; }
  std::filesystem::path path_;
};

// The socket's path for a data directory, by length; pure.
std::filesystem::path socket_path(const std::filesystem::path& data_directory, uid_t user);

}  // namespace granary::session
