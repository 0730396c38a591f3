// A sparse matrix in single precision and the vectors of conjugate gradients on it, in an order
// that suits the pattern: conjugate_gradients.h has the iteration.
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// r.r and r.z.
struct CgSizes {
  double square = 0.0, product = 0.0;
};

class CgStorage {
 public:
  virtual ~CgStorage() = default;
  // Sets the matrix to scale times a, and the preconditioner to the inverses of its diagonal
  // blocks, which must exist. This and the following functions allocate nothing.
  virtual void take(const BlockMatrix& a, double scale) = 0;
  // r = scale b; d, p and q are zero. b: 3 n.
  virtual void start(const Eigen::VectorXd& b, double scale) = 0;
  // q = A p; returns p.q.
  virtual double multiply() = 0;
  // d += alpha p, r -= alpha q, z = the diagonal's inverse times r.
  virtual CgSizes advance(float alpha) = 0;
  // p = z + beta p.
  virtual void turn(float beta) = 0;
  // x += scale d; x = p.
  virtual void add_found(double scale, Eigen::VectorXd& x) const = 0;
  virtual void copy_direction(Eigen::VectorXd& x) const = 0;
};

// Blocks of both triangles row by row, in vectors of four floats; suitable for any pattern.
std::unique_ptr<CgStorage> make_cg_rows(const BlockPattern& pattern);

// Blocks of one triangle, sixteen at a time that follow each other along the matrix's diagonal, as
// in grids; x, y and z of vectors separate. Null if too few blocks have such a neighbour.
std::unique_ptr<CgStorage> make_cg_runs(const BlockPattern& pattern);

}  // namespace tremolo
