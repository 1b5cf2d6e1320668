// A full disk for real programs: preloaded into granaryd, it lets writes, truncations and syncs fail with
// ENOSPC for files below $GRANARY_TEST_FULL_ROOT, as long as the file $GRANARY_TEST_FULL_FLAG exists.
// Everything above the system calls (SQLite, the artifact store) is the real thing.
#include <dlfcn.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

bool is_full(int descriptor) {
  static const char* const root = std::getenv("GRANARY_TEST_FULL_ROOT");
  static const char* const flag = std::getenv("GRANARY_TEST_FULL_FLAG");
  if (!root || !flag || ::access(flag, F_OK) != 0) return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = ::readlink(link, path, sizeof path - 1);
  return length > 0 && std::strncmp(path, root, std::strlen(root)) == 0;
}

template <typename Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

#define GRANARY_FAIL_WHEN_FULL(descriptor) \
  if (is_full(descriptor)) {               \
    errno = ENOSPC;                        \
    return -1;                             \
  }

extern "C" {

ssize_t write(int descriptor, const void* data, size_t bytes) {
  static const auto next = real<ssize_t (*)(int, const void*, size_t)>("write");
  GRANARY_FAIL_WHEN_FULL(descriptor)
  return next(descriptor, data, bytes);
}

ssize_t pwrite64(int descriptor, const void* data, size_t bytes, off64_t offset) {
  static const auto next = real<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  GRANARY_FAIL_WHEN_FULL(descriptor)
  return next(descriptor, data, bytes, offset);
}

ssize_t pwrite(int descriptor, const void* data, size_t bytes, off_t offset) {
  static const auto next = real<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite");
  GRANARY_FAIL_WHEN_FULL(descriptor)
  return next(descriptor, data, bytes, offset);
}

int fsync(int descriptor) {
  static const auto next = real<int (*)(int)>("fsync");
  GRANARY_FAIL_WHEN_FULL(descriptor)
  return next(descriptor);
}

int fdatasync(int descriptor) {
  static const auto next = real<int (*)(int)>("fdatasync");
  GRANARY_FAIL_WHEN_FULL(descriptor)
  return next(descriptor);
}

}  // extern "C"
