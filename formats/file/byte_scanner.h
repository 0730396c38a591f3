// Binary numbers of a file in memory, with their offsets.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/result.h"

namespace tremolo {

// True if a little-endian file's numbers have another byte order than this machine's.
inline constexpr bool kSwapsLittleEndian = std::endian::native != std::endian::little;

// Reads bytes that must outlive it. A read that fails returns false and leaves an error (kContent)
// with file, byte offset, the expected and the found value.
class ByteScanner {
 public:
  // Starts at `offset`; `swap`: the numbers have the other byte order than this machine.
  ByteScanner(std::string_view bytes, std::string file, std::size_t offset, bool swap);

  template <class T>
  bool read(T& value, std::string_view what);

  // True if `count` items of `size` bytes each follow; call it before memory is allocated.
  bool fits(std::size_t count, std::size_t size, std::string_view what);
  bool skip(std::size_t count, std::size_t size, std::string_view what);

  std::size_t offset() const { return at_; }
  std::size_t remaining() const { return bytes_.size() - at_; }
  // "FILE, byte 120: PROBLEM" at the last number read.
  Error problem(const std::string& text) const;
  const Error& error() const { return error_; }

 private:
  std::string_view bytes_;
  std::string file_;
  std::size_t at_;
  std::size_t last_;
  bool swap_;
  Error error_;
};

// The same number in the other byte order.
template <class T>
T swapped_bytes(T value) {
  static_assert(std::is_arithmetic_v<T>);
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

template <class T>
bool ByteScanner::read(T& value, std::string_view what) {
  if (sizeof(T) > remaining()) return fits(1, sizeof(T), what);
  std::memcpy(&value, bytes_.data() + at_, sizeof(T));
  if (swap_) value = swapped_bytes(value);
  last_ = at_;
  at_ += sizeof(T);
  return true;
}

}  // namespace tremolo
