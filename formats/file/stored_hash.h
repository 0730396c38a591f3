// Checksums that stand in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/hash.h"

namespace tremolo {

// The fuzzer's own build looks behind the checksums; nothing that is shipped is built like that.
#ifdef TREMOLO_FUZZING
inline constexpr bool kCheckHashes = false;
#else
inline constexpr bool kCheckHashes = true;
#endif

inline bool hash_fits(std::span<const std::byte> bytes, std::uint64_t hash) {
  return !kCheckHashes || hash_bytes(bytes) == hash;
}

}  // namespace tremolo
