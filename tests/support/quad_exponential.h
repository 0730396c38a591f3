// The exponential of a small matrix in numbers of 113 bits: the exact result of linear motion, by a
// power series of the matrix over 2^n and n squarings. It has nothing in common with the tested
// code.
#pragma once

#include <array>
#include <cstddef>

namespace tremolo::testing {

__extension__ typedef __float128 Quad;

template <std::size_t n>
using QuadMatrix = std::array<std::array<Quad, n>, n>;

template <std::size_t n>
QuadMatrix<n> operator*(const QuadMatrix<n>& a, const QuadMatrix<n>& b) {
  QuadMatrix<n> c{};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      if (a[i][k] != 0)
        for (std::size_t j = 0; j < n; ++j) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// e^A; entries up to 1e14 leave 15 digits and more.
template <std::size_t n>
QuadMatrix<n> exponential(QuadMatrix<n> a) {
  Quad largest = 0;
  for (const auto& row : a)
    for (const Quad entry : row)
      largest = entry > largest ? entry : -entry > largest ? -entry : largest;
  int squarings = 0;
  for (; largest > 0.01; largest /= 2) ++squarings;
  for (auto& row : a)
    for (Quad& entry : row)
      for (int k = 0; k < squarings; ++k) entry /= 2;
  QuadMatrix<n> sum{}, power{};
  for (std::size_t i = 0; i < n; ++i) sum[i][i] = power[i][i] = 1;
  for (int k = 1; k <= 18; ++k) {
    power = power * a;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) sum[i][j] += power[i][j] /= k;
  }
  for (int k = 0; k < squarings; ++k) sum = sum * sum;
  return sum;
}

}  // namespace tremolo::testing
