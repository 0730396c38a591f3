// The small mesh that the tests of the readers write in every format, and tools for writing it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

#include "common/mesh/tet_mesh.h"

namespace tremolo::testing {

// Gaps and no order, as Gmsh may leave them.
inline constexpr std::array<int, 5> kNodeIds{2, 9, 5, 7, 3};
// A cell that is no tetrahedron, in the files that may hold one.
inline constexpr Triangle kTriangle{0, 1, 2};

inline std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

inline std::string join(const Eigen::Vector3d& x) {
  return number(x[0]) + " " + number(x[1]) + " " + number(x[2]);
}

template <class Cell>
inline std::string join(const Cell& cell, int base) {
  std::string text;
  for (VertexId v : cell) text += " " + std::to_string(v + base);
  return text;
}

template <class Cell>
inline std::string join_ids(const Cell& cell) {
  std::string text;
  for (VertexId v : cell) text += " " + std::to_string(kNodeIds[v]);
  return text;
}

// Numbers as bytes in either order.
class ByteWriter {
 public:
  explicit ByteWriter(bool big_endian)
      : swap_(big_endian == (std::endian::native != std::endian::big)) {}
  template <class T>
  ByteWriter& put(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (swap_) std::reverse(bytes.begin(), bytes.end());
    text_.append(bytes.data(), bytes.size());
    return *this;
  }
  ByteWriter& put(const Eigen::Vector3d& x) { return put(x[0]).put(x[1]).put(x[2]); }
  ByteWriter& text(const std::string& text) {
    text_ += text;
    return *this;
  }
  const std::string& str() const { return text_; }

 private:
  std::string text_;
  bool swap_;
};

inline std::string base64(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t bits = 0;
    for (std::size_t n = 0; n < 3; ++n)
      bits = bits << 8 | (at + n < bytes.size() ? static_cast<unsigned char>(bytes[at + n]) : 0u);
    for (std::size_t n = 0; n < 4; ++n)
      text += at + n > bytes.size() ? '=' : digits[bits >> (18 - 6 * n) & 63u];
  }
  return text;
}

// Five vertices, two tetrahedra with a common face.
inline TetMesh small_mesh() {
  TetMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.125, -0.25, 1}, {1, 1, 1.5}};
  mesh.tetrahedra = {{0, 1, 2, 3}, {1, 4, 2, 3}};
  return mesh;
}

}  // namespace tremolo::testing
