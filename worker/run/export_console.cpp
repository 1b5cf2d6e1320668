#include "worker/run/export_console.h"

#include <iostream>

#include "proto/contract/result.h"
#include "worker/storage/csv_export.h"
#include "worker/storage/frame_export.h"
#include "worker/storage/picture_export.h"
#include "worker/storage/storage_error.h"

namespace granary::run {

namespace {

std::vector<storage::Path> export_as(const std::string& form, const storage::Path& input,
                                     const storage::Path& directory) {
  if (form == "xyz") return storage::export_xyz(input, directory);
  if (form == "paraview") return storage::export_paraview(input, directory);
  if (form == "svg") return {storage::export_picture(input, directory)};
  return storage::export_csv(input, directory);
}

}  // namespace

int export_console(const std::string& input_file, const std::string& form,
                   const std::string& directory) {
  try {
    for (const auto& file : export_as(form, input_file, directory))
      std::cout << file.string() << '\n';
    return 0;
  } catch (const storage::StorageError& error) {
    std::cerr << "granary-worker: " << error.what() << '\n';
    const bool is_output = error.fault() == storage::StorageFault::io ||
                           error.fault() == storage::StorageFault::disk_full ||
                           error.fault() == storage::StorageFault::missing;
    return static_cast<int>(is_output ? ExitCode::usage : ExitCode::verification_failed);
  }
}

}  // namespace granary::run
