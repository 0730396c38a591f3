// Arrays that begin at a cache line, so that no vector load crosses two.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace tremolo {

inline constexpr std::size_t kCacheLine = 64;  // bytes

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class Other>
  CacheLineAllocator(const CacheLineAllocator<Other>&) {}  // NOLINT: an allocator converts
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kCacheLine}));
  }
  void deallocate(T* first, std::size_t) {
    ::operator delete (first, std::align_val_t{kCacheLine});
  }
  bool operator==(const CacheLineAllocator&) const { return true; }
};

using AlignedDoubles = std::vector<double, CacheLineAllocator<double>>;
using AlignedFloats = std::vector<float, CacheLineAllocator<float>>;

}  // namespace tremolo
