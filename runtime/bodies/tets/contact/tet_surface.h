// A drawn surface attached to a body of tetrahedra. A vertex with barycentric weights w in an
// element is at
//   x = sum_I B_I(w) x_I,       its normal along cof(F(w)) n,   F = sum_I x_I (grad B_I)^T,
// which is F t x F s for two tangents at rest with t x s = n, each a weighted sum of the x_I. B_I
// are the quadratic Bernstein polynomials. A linear edge has its control point at the mean of its
// ends, so that the same formula applies to it.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

class TetSurface {
 public:
  // surface: from the file of the model (read_tets has checked it).
  TetSurface(TetModelPointer model, TetsSurface surface);

  std::size_t vertices() const { return surface_.vertices.size(); }
  const TetsSurface& rest() const { return surface_; }

  // Computes positions, m, and normals, of length 1 (zero where an element is flat), one per
  // vertex. x: control points, 3 nodes(). Allocates nothing.
  void place(const Eigen::VectorXd& x, std::vector<Eigen::Vector3d>& vertices,
             std::vector<Eigen::Vector3f>& normals) const;
  std::size_t bytes() const;

 private:
  TetModelPointer model_;
  TetsSurface surface_;
  // For each vertex B_I(w), and grad B_I . t, grad B_I . s.
  std::vector<std::array<double, 3 * kMostNodes>> shares_;
};

}  // namespace tremolo
