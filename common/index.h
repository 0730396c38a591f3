// The integer types of the code and their uses (docs/architecture.md, "Errors, output and integers
// in code").
#pragma once

#include <concepts>
#include <cstddef>
#include <utility>

namespace tremolo {

// Returns true if `number`, from a file or a user, is an index into `count` things.
constexpr bool is_index(std::integral auto number, std::size_t count) {
  return std::cmp_greater_equal(number, 0) && std::cmp_less(number, count);
}

}  // namespace tremolo
