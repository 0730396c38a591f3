// Values of assimp as ours.
#pragma once

#include <algorithm>
#include <assimp/types.h>
#include <string_view>

#include <Eigen/Core>

namespace tremolo {

inline std::string_view text_of(const aiString& text) {
  return {text.data, std::min<std::size_t>(text.length, sizeof(text.data) - 1)};
}

inline Eigen::Matrix4d matrix_of(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return matrix;
}

}  // namespace tremolo
