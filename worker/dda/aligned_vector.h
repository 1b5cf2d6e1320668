// Vectors whose storage starts on a cache line, so that the kernels may load whole registers.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace granary::dda {

inline constexpr std::size_t kCacheLineBytes = 64;

// From here on storage lies in huge pages of its own, where the system has any, and starts in
// another set of the caches than the allocation before: arrays that are gone through together would
// otherwise push each other out, and miss a page in every fourth kilobyte.
inline constexpr std::size_t kLargeBytes = 1 << 20;
void* allocate_large(std::size_t bytes);  // throws std::bad_alloc
void free_large(void* pointer);

template <typename T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <typename U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}  // NOLINT: converting, as allocators must

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes >= kLargeBytes) return static_cast<T*>(allocate_large(bytes));
    return static_cast<T*>(::operator new (bytes, std::align_val_t{kCacheLineBytes}));
  }
  void deallocate(T* pointer, std::size_t count) {
    if (count * sizeof(T) >= kLargeBytes) return free_large(pointer);
    ::operator delete (pointer, std::align_val_t{kCacheLineBytes});
  }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
};

template <typename T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

}  // namespace granary::dda
