// Files that exports leave for people: made whole or reported, never fsynced (they can be made again).
#pragma once

#include <string>

#include "worker/storage/file_system.h"

namespace granary::storage {

void make_directory(const Path& directory);
void write_text(const Path& path, const std::string& text);

}  // namespace granary::storage
