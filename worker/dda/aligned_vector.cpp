#include "worker/dda/aligned_vector.h"

#include <sys/mman.h>

#include <atomic>
#include <cstdlib>

namespace granary::dda {
namespace {

constexpr std::size_t kHugePageBytes = 2 << 20;
// Seventeen lines from one allocation to the next: the sets of a cache are a power of two.
constexpr std::size_t kStaggerBytes = 17 * kCacheLineBytes;
constexpr unsigned kStaggers = 32;

std::atomic<unsigned> allocations = 0;

}  // namespace

// The line before the storage holds where the allocation starts.
void* allocate_large(std::size_t bytes) {
  const std::size_t offset = kCacheLineBytes + kStaggerBytes * (allocations++ % kStaggers);
  const std::size_t whole = (offset + bytes + kHugePageBytes - 1) / kHugePageBytes * kHugePageBytes;
  void* base = std::aligned_alloc(kHugePageBytes, whole);
  if (base == nullptr) throw std::bad_alloc();
  madvise(base, whole, MADV_HUGEPAGE);  // a wish: what comes instead is as right and slower
  char* storage = static_cast<char*>(base) + offset;
  *reinterpret_cast<void**>(storage - kCacheLineBytes) = base;
  return storage;
}

void free_large(void* pointer) {
  std::free(*reinterpret_cast<void**>(static_cast<char*>(pointer) - kCacheLineBytes));
}

}  // namespace granary::dda
