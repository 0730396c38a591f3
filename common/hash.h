// XXH3-64, the checksum of everything Tremolo writes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace tremolo {

// XXH3-64 with seed 0 of the bytes in memory.
std::uint64_t hash_bytes(std::span<const std::byte> bytes);

// The same for bytes in several pieces.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;
  void add(std::span<const std::byte> bytes);
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// 16 lower-case hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace tremolo
