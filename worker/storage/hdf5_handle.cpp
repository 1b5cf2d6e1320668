#include "worker/storage/hdf5_handle.h"

#include <cerrno>
#include <cstring>

#include "worker/storage/storage_error.h"

namespace granary::storage::hdf5 {
namespace {

// The innermost description: "unable to write ... errno = 28, error message = 'No space left ...'".
herr_t keep_description(unsigned /*depth*/, const H5E_error2_t* entry, void* text) {
  if (entry->desc != nullptr) *static_cast<std::string*>(text) = entry->desc;
  return 0;
}

bool names_full_disk(const std::string& text) {
  for (const int error : {ENOSPC, EDQUOT, EFBIG})
    if (text.find(std::strerror(error)) != std::string::npos) return true;
  return false;
}

}  // namespace

void throw_last_error(const std::string& doing) {
  std::string description;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep_description, &description);
  H5Eclear2(H5E_DEFAULT);
  const bool disk_full = names_full_disk(description);
  throw StorageError(disk_full ? StorageFault::disk_full : StorageFault::io,
                     "cannot " + doing + (description.empty() ? "" : ": " + description));
}

void prepare_library() {
  // A file whose close failed (disk full) stays half open inside the library, and its clean-up at
  // exit then crashes. Every handle is closed here, so there is nothing to clean up.
  static const herr_t once = H5dont_atexit();
  (void)once;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

}  // namespace granary::storage::hdf5
