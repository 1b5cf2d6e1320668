// Internal to worker/storage: HDF5 identifiers that close themselves, and failures as StorageError.
#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

namespace granary::storage::hdf5 {

// Throws StorageError with what the library says about its last failure (disk full is recognised).
[[noreturn]] void throw_last_error(const std::string& doing);

// Owns one identifier of any kind. Construction with a negative id throws.
class Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  Handle(hid_t id, Closer closer, const std::string& doing) : id_(id), closer_(closer) {
    if (id_ < 0) throw_last_error(doing);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), closer_(other.closer_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(closer_, other.closer_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) closer_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: passes straight into the C interface

  // Closing writes: a file must be closed where the failure can still be reported.
  void close(const std::string& doing) {
    if (closer_(std::exchange(id_, -1)) < 0) throw_last_error(doing);
  }

 private:
  hid_t id_;
  Closer closer_;
};

inline void check(herr_t status, const std::string& doing) {
  if (status < 0) throw_last_error(doing);
}

// To be called before the first use. The library prints every failure by default; ours are reported
// by exception.
void prepare_library();

}  // namespace granary::storage::hdf5
