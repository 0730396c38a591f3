// A linear system of several bodies: a dense block for each body, and two blocks for each pair in
// contact.
//
// GMRES with right preconditioning (Saad and Schultz, 1986). The preconditioner is the block LU
// decomposition without fill, D_k = A_kk - sum_j A_kj D_j^-1 A_jk over the neighbours j before k, M
// = (D + L) D^-1 (D + U). Bodies with few neighbours are first: if contacts form no cycles, as in a
// stack or a chain, M is A and one iteration is enough. If GMRES does not reach its tolerance, as
// in tall jammed piles, a sparse LU decomposition solves the system.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/math/dense/dense_lu.h"

namespace tremolo {

// Two bodies in contact.
struct BlockLink {
  std::size_t a = 0, b = 0;
  const Eigen::MatrixXd* ab = nullptr;  // block of the rows of a and the unknowns of b
  const Eigen::MatrixXd* ba = nullptr;  // block of the rows of b and the unknowns of a
};

// The system.
struct BlockSystem {
  // Index of each body's first unknown; the last entry is the number of all.
  std::span<const Eigen::Index> first;
  // For each body a matrix whose top left block is the diagonal block.
  std::span<const Eigen::MatrixXd* const> diagonal;
  std::span<const BlockLink> links;  // at most one per pair
  // Factor of each row, above zero, which gives all rows one unit.
  const Eigen::VectorXd* scale = nullptr;

  std::size_t bodies() const { return diagonal.size(); }
  Eigen::Index unknowns() const { return first[diagonal.size()]; }
};

class BlockSolver {
 public:
  static constexpr int kMostIterations = 60;
  static constexpr double kTolerance = 1e-8;  // of the scaled residual, relative

  // Solves A x = b; both vectors are at least unknowns() long. tolerance: of the scaled residual,
  // relative. False: no finite solution. Memory grows with the largest system so far; the sparse
  // decomposition allocates.
  bool solve(const BlockSystem& system, const Eigen::VectorXd& b, Eigen::VectorXd& x,
             double tolerance = kTolerance);

  // Iterations of the last solve; kMostIterations + 1: the sparse decomposition solved it.
  int iterations() const { return iterations_; }

 private:
  // Another body in a row, and the block there.
  struct Neighbour {
    std::size_t body = 0;
    const Eigen::MatrixXd* block = nullptr;
    const Eigen::MatrixXd* back = nullptr;  // from the other's row to this body
  };

  void find_neighbours();
  void find_order();
  bool decompose();
  void multiply(const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> y) const;
  void precondition(const Eigen::Ref<const Eigen::VectorXd>& b, Eigen::VectorXd& x);
  bool iterate(const Eigen::VectorXd& b, Eigen::VectorXd& x, double tolerance);
  bool solve_sparse(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;

  const BlockSystem* system_ = nullptr;
  std::vector<std::vector<Neighbour>> neighbours_;
  std::vector<std::size_t> order_, rank_, degree_;
  std::vector<Eigen::MatrixXd> inverse_;  // of D_k
  DenseLu factor_;
  Eigen::MatrixXd d_, through_, basis_, hessenberg_;
  Eigen::VectorXd part_, image_, turned_, cosine_, sine_;
  int iterations_ = 0;
};

}  // namespace tremolo
