// The packing of symmetric coefficients; it is defined only here.
//
// A fully symmetric tensor of order d over r coordinates has C(r+d-1, d) unique entries, those
// with i <= j <= k <= l. They are stored in colexicographic order: sorted by the largest index
// first, then by the next. The position of an entry does not depend on r, so the entries of the
// first R coordinates are a prefix: leaving trailing coordinates out means reading less.
#pragma once

#include <concepts>
#include <cstddef>
#include <utility>

namespace tremolo {

// Number of unique entries of a symmetric tensor of order 2, 3, 4 over r coordinates.
constexpr std::size_t pair_count(std::size_t r) {
  return r * (r + 1) / 2;
}
constexpr std::size_t triple_count(std::size_t r) {
  return r * (r + 1) * (r + 2) / 6;
}
constexpr std::size_t quad_count(std::size_t r) {
  return r * (r + 1) / 2 * ((r + 2) * (r + 3) / 2) / 6;
}

// Number of terms of a quadratic strain over r coordinates: q_0, q_0 q_0, q_1, q_0 q_1, q_1 q_1,
// ... They are the pairs of (1, q_0 .. q_{r-1}) in the order of pair_index, without the constant,
// so that those of the first R coordinates are a prefix, too.
constexpr std::size_t strain_terms(std::size_t r) {
  return pair_count(r + 1) - 1;
}

// Place of entry i <= j (<= k <= l), zero-based.
constexpr std::size_t pair_index(std::size_t i, std::size_t j) {
  return pair_count(j) + i;
}
// Place of the strain terms q_j and, for i <= j, q_i q_j.
constexpr std::size_t strain_index(std::size_t j) {
  return pair_index(0, j + 1) - 1;
}
constexpr std::size_t strain_index(std::size_t i, std::size_t j) {
  return pair_index(i + 1, j + 1) - 1;
}
constexpr std::size_t triple_index(std::size_t i, std::size_t j, std::size_t k) {
  return triple_count(k) + pair_index(i, j);
}
constexpr std::size_t quad_index(std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
  return quad_count(l) + triple_index(i, j, k);
}

namespace detail {
template <class T>
constexpr void sort_two(T& a, T& b) {
  if (b < a) {
    const T t = a;
    a = b;
    b = t;
  }
}
}  // namespace detail

// The same for indices in any order.
constexpr std::size_t pair_index_any(std::size_t i, std::size_t j) {
  detail::sort_two(i, j);
  return pair_index(i, j);
}
constexpr std::size_t triple_index_any(std::size_t i, std::size_t j, std::size_t k) {
  detail::sort_two(i, j);
  detail::sort_two(j, k);
  detail::sort_two(i, j);
  return triple_index(i, j, k);
}
constexpr std::size_t quad_index_any(std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
  detail::sort_two(i, j);
  detail::sort_two(k, l);
  detail::sort_two(i, k);
  detail::sort_two(j, l);
  detail::sort_two(j, k);
  return quad_index(i, j, k, l);
}

// Number of orderings of an index triple or quadruple i <= j <= k (<= l): the factor between a
// tensor entry and the coefficient of its monomial.
constexpr int orderings(std::size_t i, std::size_t j, std::size_t k) {
  return i == k ? 1 : (i == j || j == k) ? 3 : 6;
}
constexpr int orderings(std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
  int count = 24;
  std::size_t run = 1;
  const std::size_t sorted[4] = {i, j, k, l};
  for (int n = 1; n < 4; ++n) {
    run = sorted[n] == sorted[n - 1] ? run + 1 : 1;
    count /= static_cast<int>(run);
  }
  return count;
}

}  // namespace tremolo

namespace tremolo {

// The integer types of the code and their uses (docs/architecture.md, "Errors, output and integers
// in code").

// Returns true if `number`, from a file or a user, is an index into `count` things.
constexpr bool is_index(std::integral auto number, std::size_t count) {
  return std::cmp_greater_equal(number, 0) && std::cmp_less(number, count);
}

}  // namespace tremolo
