// Numbers, names and checksums at fixed offsets of a binary file, little-endian as this machine.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "common/hash.h"

namespace tremolo {

static_assert(std::endian::native == std::endian::little, "values are written as they lie");

// The number at byte `at`, which need not be aligned.
template <class T>
T get(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

template <class T>
void put(std::span<std::byte> bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

// Appends values to `bytes`.
template <class T>
void append_bytes(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}
template <class T>
void append_bytes(std::string& bytes, T value) {
  append_bytes(bytes, &value, 1);
}

// The number of zero bytes before the first other byte.
inline std::size_t leading_zeros(std::span<const std::byte> bytes) {
  return std::find_if(bytes.begin(), bytes.end(), [](std::byte b) { return b != std::byte{0}; }) -
         bytes.begin();
}

// The name in a field padded with zeros; empty if there is none or other bytes follow it.
inline std::string_view padded_name(std::span<const std::byte> field) {
  const std::string_view text(reinterpret_cast<const char*>(field.data()), field.size());
  const std::string_view name = text.substr(0, text.find('\0'));
  const auto padding = field.subspan(name.size());
  return leading_zeros(padding) == padding.size() ? name : std::string_view();
}

// The fuzzer's build skips the checksums to reach the code behind them; no shipped build does.
#ifdef TREMOLO_FUZZING
inline constexpr bool kCheckHashes = false;
#else
inline constexpr bool kCheckHashes = true;
#endif

inline bool hash_fits(std::span<const std::byte> bytes, std::uint64_t hash) {
  return !kCheckHashes || hash_bytes(bytes) == hash;
}

}  // namespace tremolo
