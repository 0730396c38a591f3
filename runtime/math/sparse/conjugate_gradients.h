// A x = b by conjugate gradients, preconditioned by the inverses of the diagonal's blocks
// (Hestenes and Stiefel 1952), in single precision inside a refinement in double precision:
//
//     r = b - A x,   A d ~ r by conjugate gradients in floats,   x <- x + d,   and again.
//
// Most of the time is spent reading A from memory in every iteration: in floats it is half as long,
// and in runs (make_cg_runs()) only one of its triangles is read.
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

// r.r and r.z.
struct CgSizes {
  double square = 0.0, product = 0.0;
};

// A sparse matrix in single precision and the vectors of conjugate gradients on it, in an order
// that suits the pattern.
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

// Result of a solve.
struct CgReport {
  int iterations = 0;
  double residual = 0.0;   // |b - A x| at the end, in b's unit
  bool converged = false;  // the residual is at most the requested one
  // No direction with d.A d <= 0 was met, and every diagonal block has an inverse; otherwise x is
  // the solution before that.
  bool positive = true;
};

class ConjugateGradients {
 public:
  // Sized for matrices of this pattern; nothing is allocated later.
  explicit ConjugateGradients(const BlockPattern& pattern);

  // Starts from the given x. residual: absolute, in b's unit, Euclidean norm, at which the solve
  // stops.
  CgReport solve(const BlockMatrix& a, const Eigen::VectorXd& b, Eigen::VectorXd& x,
                 double residual, int max_iterations);

 private:
  bool take(const BlockMatrix& a);
  double search(double tolerance, int most, CgReport& report);
  bool is_positive(const BlockMatrix& a);

  std::size_t n_ = 0;
  double scale_ = 1.0;  // of the matrix in floats
  std::unique_ptr<CgStorage> storage_;
  Eigen::VectorXd rest_, image_;  // b - A x; a product with A
};

}  // namespace tremolo
