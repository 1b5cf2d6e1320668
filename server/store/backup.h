// A consistent copy of the live database, made on a connection of its own: writers are not kept waiting.
#pragma once

#include <filesystem>

namespace granary::server {

// `target` must not exist. Throws std::exception: disk full, or the copy does not pass SQLite's check.
void copy_database(const std::filesystem::path& source, const std::filesystem::path& target);

}  // namespace granary::server
