#include "server/ops/disk_space.h"

#include <sys/statfs.h>

#include <array>
#include <utility>

namespace granary::server {
namespace {

// linux/magic.h and the kernel's sources; those in wide use. Not 9P: sandboxes show local disks as that.
constexpr std::array<std::pair<std::uint64_t, const char*>, 10> kNetworkFileSystems = {{
    {0x6969, "NFS"},
    {0xFF534D42, "CIFS"},
    {0xFE534D42, "SMB2"},
    {0x517B, "SMB"},
    {0x564C, "NCP"},
    {0x73757245, "Coda"},
    {0x5346414F, "AFS"},
    {0x00C36400, "Ceph"},
    {0x0BD00BD0, "Lustre"},
    {0x47504653, "GPFS"},
}};

std::string megabytes(std::uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MB";
}

}  // namespace

std::string intake_refusal(std::uint64_t free_bytes, std::uint64_t kept_bytes, bool refused_before) {
  const std::uint64_t wanted = refused_before ? kept_bytes + kept_bytes / 4 : kept_bytes;
  if (free_bytes >= wanted) return {};
  return "the server's disk has " + megabytes(free_bytes) + " left and keeps " + megabytes(kept_bytes) +
         " for running jobs: nothing was queued, try again when there is room";
}

std::uint64_t free_bytes_of(const std::filesystem::path& folder) {
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  return error ? 0 : space.available;
}

const char* network_file_system(std::uint64_t magic) {
  for (const auto& [number, name] : kNetworkFileSystems)
    if (number == magic) return name;
  return nullptr;
}

Status check_local_file_system(const std::filesystem::path& folder) {
  struct statfs found {};
  if (::statfs(folder.c_str(), &found) != 0) return Done{};  // what follows will say it better
  const char* name = network_file_system(static_cast<std::uint32_t>(found.f_type));
  if (!name) return Done{};
  return Error{ErrorCode::failed_precondition,
               folder.string() + " is on " + name +
                   ": a database there can be damaged, choose a --data directory on a local disk",
               "data"};
}

}  // namespace granary::server
