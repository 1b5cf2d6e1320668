// The tables of a result file as CSV: /series/NAME and /fields/NAME become NAME.csv, one column per
// dataset, named with its unit. Rows without data (a NaN in any column) are left out.
#pragma once

#include <vector>

#include "worker/storage/file_system.h"

namespace granary::storage {

// Makes the directory if need be; existing files of these names are replaced. Returns the files
// written. Throws StorageError.
std::vector<Path> export_csv(const Path& result, const Path& directory);

}  // namespace granary::storage
