// A drawn surface that hangs on a body of tetrahedra. A vertex with barycentric weights w in an
// element is at
//   x = sum_I B_I(w) x_I,       its normal along cof(F(w)) n,   F = sum_I x_I (grad B_I)^T,
// which is F t x F s of two tangents at rest with t x s = n, each a sum of shares of the x_I, with
// the quadratic Bernstein polynomials B_I: a linear edge has its control point at the mean of
// its ends, so that the same formula serves it.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

class TetSurface {
 public:
  // surface: of the file that the model was made of (read_tets has checked it).
  TetSurface(TetModelPointer model, TetsSurface surface);

  std::size_t vertices() const { return surface_.vertices.size(); }
  const TetsSurface& rest() const { return surface_; }

  // x: control points, 3 nodes(). Both as many as vertices(), m and of length 1 (zero where an
  // element is flat). Allocates nothing.
  void place(const Eigen::VectorXd& x, std::vector<Eigen::Vector3d>& vertices,
             std::vector<Eigen::Vector3f>& normals) const;
  std::size_t bytes() const;

 private:
  TetModelPointer model_;
  TetsSurface surface_;
  // Each vertex has B_I(w), and grad B_I . t, grad B_I . s.
  std::vector<std::array<double, 3 * kMostNodes>> shares_;
};

}  // namespace tremolo
