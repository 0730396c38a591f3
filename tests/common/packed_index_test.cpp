#include "common/packed_index.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

constexpr std::size_t kSize = 9;

TEST(PackedIndex, PairsAreNumberedWithoutGapsInOrder) {
  std::size_t expected = 0;
  for (std::size_t j = 0; j < kSize; ++j)
    for (std::size_t i = 0; i <= j; ++i) EXPECT_EQ(pair_index(i, j), expected++);
  EXPECT_EQ(expected, pair_count(kSize));
}

TEST(PackedIndex, TriplesAreNumberedWithoutGapsInOrder) {
  std::size_t expected = 0;
  for (std::size_t k = 0; k < kSize; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t i = 0; i <= j; ++i) EXPECT_EQ(triple_index(i, j, k), expected++);
  EXPECT_EQ(expected, triple_count(kSize));
}

TEST(PackedIndex, QuadruplesAreNumberedWithoutGapsInOrder) {
  std::size_t expected = 0;
  for (std::size_t l = 0; l < kSize; ++l)
    for (std::size_t k = 0; k <= l; ++k)
      for (std::size_t j = 0; j <= k; ++j)
        for (std::size_t i = 0; i <= j; ++i) EXPECT_EQ(quad_index(i, j, k, l), expected++);
  EXPECT_EQ(expected, quad_count(kSize));
}

TEST(PackedIndex, EntriesOfFewerCoordinatesAreAPrefix) {
  for (std::size_t r = 1; r < kSize; ++r) {
    EXPECT_EQ(pair_index(r - 1, r - 1) + 1, pair_count(r));
    EXPECT_EQ(triple_index(r - 1, r - 1, r - 1) + 1, triple_count(r));
    EXPECT_EQ(quad_index(r - 1, r - 1, r - 1, r - 1) + 1, quad_count(r));
    EXPECT_EQ(pair_index(0, r), pair_count(r));
    EXPECT_EQ(triple_index(0, 0, r), triple_count(r));
    EXPECT_EQ(quad_index(0, 0, 0, r), quad_count(r));
  }
}

TEST(PackedIndex, CountsStayExactAtTheLargestNumberOfModes) {
  // 4096 coordinates: the products inside the formulas must not leave 64 bits.
  EXPECT_EQ(triple_count(4096), 11461636096u);
  EXPECT_EQ(quad_count(4096), 11745311589376u);
}

TEST(PackedIndex, EveryOrderOfIndicesHasTheSamePlace) {
  for (std::size_t l = 0; l < 5; ++l)
    for (std::size_t k = 0; k <= l; ++k)
      for (std::size_t j = 0; j <= k; ++j)
        for (std::size_t i = 0; i <= j; ++i) {
          std::array<std::size_t, 4> n{i, j, k, l};
          do {
            EXPECT_EQ(quad_index_any(n[0], n[1], n[2], n[3]), quad_index(i, j, k, l));
          } while (std::next_permutation(n.begin(), n.end()));
          std::array<std::size_t, 3> m{i, j, k};
          do {
            EXPECT_EQ(triple_index_any(m[0], m[1], m[2]), triple_index(i, j, k));
          } while (std::next_permutation(m.begin(), m.end()));
          EXPECT_EQ(pair_index_any(j, i), pair_index(i, j));
        }
}

TEST(PackedIndex, OrderingsSumToAllEntriesOfTheFullTensor) {
  for (std::size_t r = 1; r < kSize; ++r) {
    std::size_t triples = 0;
    std::size_t quads = 0;
    for (std::size_t l = 0; l < r; ++l)
      for (std::size_t k = 0; k <= l; ++k)
        for (std::size_t j = 0; j <= k; ++j) {
          triples += static_cast<std::size_t>(orderings(j, k, l));
          for (std::size_t i = 0; i <= j; ++i)
            quads += static_cast<std::size_t>(orderings(i, j, k, l));
        }
    EXPECT_EQ(triples, r * r * r);
    EXPECT_EQ(quads, r * r * r * r);
  }
}

TEST(PackedIndex, OrderingsCountDistinctPermutations) {
  for (std::size_t l = 0; l < 4; ++l)
    for (std::size_t k = 0; k <= l; ++k)
      for (std::size_t j = 0; j <= k; ++j)
        for (std::size_t i = 0; i <= j; ++i) {
          std::array<std::size_t, 4> n{i, j, k, l};
          int count = 0;
          do {
            ++count;
          } while (std::next_permutation(n.begin(), n.end()));
          EXPECT_EQ(orderings(i, j, k, l), count) << i << j << k << l;
        }
}

}  // namespace
}  // namespace tremolo
