#include "worker/run/export_console.h"

#include <iostream>

#include "proto/contract/result.h"
#include "worker/storage/csv_export.h"
#include "worker/storage/storage_error.h"

namespace granary::run {

int export_console(const std::string& input_file, const std::string& directory) {
  try {
    for (const auto& file : storage::export_csv(input_file, directory))
      std::cout << file.string() << '\n';
    return 0;
  } catch (const storage::StorageError& error) {
    std::cerr << "granary-worker: " << error.what() << '\n';
    const bool is_output = error.fault() == storage::StorageFault::io ||
                           error.fault() == storage::StorageFault::disk_full;
    return static_cast<int>(is_output ? ExitCode::usage : ExitCode::verification_failed);
  }
}

}  // namespace granary::run
