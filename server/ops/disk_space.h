// Room on the disk of the data directory. Intake stops before the disk is full, so that jobs that are
// running can still store their results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "proto/contract/result.h"

namespace granary::server {

// Why nothing new is accepted, or empty. With a margin, so that intake does not flicker: once refused,
// a quarter more than `kept_bytes` must be free.
std::string intake_refusal(std::uint64_t free_bytes, std::uint64_t kept_bytes, bool refused_before);

std::uint64_t free_bytes_of(const std::filesystem::path& folder);  // for this user; 0 when unknown

// SQLite's locks and its shared memory need a file system of this machine. FAILED_PRECONDITION names
// the file system otherwise.
Status check_local_file_system(const std::filesystem::path& folder);
// By statfs's magic number; nullptr when it is not a network file system.
const char* network_file_system(std::uint64_t magic);

}  // namespace granary::server
