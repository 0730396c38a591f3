// The reduced St. Venant-Kirchhoff energy (docs/theory.md, "Reduced energy"; thesis 4.1):
//
//     V(q)  = 1/2 q^T Lambda q + C[q,q,q] + Q[q,q,q,q]
//     R(q)  = grad V = Lambda q + 3 C[q,q] + 4 Q[q,q,q]
//     K(q)  = grad R = Lambda   + 6 C[q]   + 12 Q[q,q]
//
// Two kernels compute them, with the same results to rounding. SymmetricKernel reads each unique
// coefficient once: it computes the force, and the tangent of large models. PairKernel multiplies a
// matrix over index pairs: it computes the tangent of small models, averages over a segment, and
// trailing rows alone. With its
//
//     X_a = q_i q_j (twice that for i != j),   A = S X,  S_ab = Q_ijkl,   B_a = sum_k C_ijk q_k,
//
// R = Lambda q + (3B + 4A) q and K = Lambda + 6B + 12A.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/kernels/pair_kernel.h"
#include "runtime/math/kernels/symmetric_kernel.h"

namespace tremolo {

// Quantities that evaluate() computes; combine with |.
enum Want : unsigned { kWantEnergy = 1, kWantForce = 2, kWantTangent = 4 };

// Results of an evaluation.
struct Evaluation {
  double energy = 0.0;  // J
  // R(q), r, J per unit of q (the internal force with the sign of +grad V).
  Eigen::VectorXd force;
  // K(q), r x r, symmetric, both triangles filled, (rad/s)^2.
  Eigen::MatrixXd tangent;
};

// Uses of a workspace in addition to energy and force; combine with |.
enum Use : unsigned {
  kUsePoint = 0,
  kUseTangent = 1,  // kWantTangent
  kUseSegment = 2,  // averaged_gradient, averaged_jacobian and the trailing rows
  kUseAll = 3
};

// Buffers of one caller, made by Potential::make_workspace; may be reused for any q of the same
// potential, not by two threads at once. x, a, b: the X, A and B above, in the order of pair_index.
struct PotentialWorkspace {
  const PairKernel* pair_kernel = nullptr;  // null if no use needs it
  SymmetricKernel::Workspace unique;
  SymmetricKernel::Workspace unique_second;  // of a second point
  AlignedDoubles q;                          // a copy of the point, followed by zeros
  AlignedDoubles second;                     // another vector
  AlignedDoubles x;
  AlignedDoubles a;
  AlignedDoubles b;
  AlignedDoubles held_a;  // contributions of the leading coordinates to A and B: begin_trailing
  AlignedDoubles held_b;
  AlignedDoubles triangle;  // 3B + 4A, which multiplies q in the force
  AlignedDoubles product;   // that product
};

class Potential {
 public:
  // lambda: r, ascending, (rad/s)^2. cubic, quartic: packed as in common/packed_index.h, at least
  // triple_count(r) and quad_count(r) entries; the leading ones are used, so that a shorter lambda
  // leaves trailing coordinates out. Both empty: a linear solid, V = 1/2 q^T Lambda q. kContent if
  // an array is too short or a value is not finite.
  static Result<Potential> create(Eigen::VectorXd lambda, std::span<const double> cubic,
                                  std::span<const double> quartic);

  // V(q_1..q_count, 0..0) as a function of the leading `count` coordinates, 0 <= count <= r.
  Potential leading(Eigen::Index count) const;

  Eigen::Index size() const { return lambda_.size(); }  // r
  bool linear() const { return coefficients_ == nullptr; }
  // Unique entries of C and Q, packed as in common/packed_index.h; empty if linear.
  std::span<const double> cubic() const;
  std::span<const double> quartic() const;
  const Eigen::VectorXd& lambda() const { return lambda_; }

  // Makes a workspace for the named uses, and for energy and force always. Data for a use is made
  // at the first call and shared by all copies of the potential: matrices of C(p+1,2) coefficients,
  // p = pair_count(r), for kUseSegment and, below r = 20, for kUseTangent. Thread-safe.
  PotentialWorkspace make_workspace(unsigned uses = kUseAll) const;
  Evaluation make_evaluation() const;

  // Sets the parts of `out` named by `want`; the others are unchanged. q: r. Nothing is allocated.
  void evaluate(const Eigen::VectorXd& q, unsigned want, PotentialWorkspace& workspace,
                Evaluation& out) const;

  // The trailing rows alone, for a solve in which the leading `held` coordinates are constant.
  // begin_trailing() contracts the terms of those only, once. evaluate_trailing() then sets
  // force[held..r) and, on request, the block tangent[held..r, held..r) for a q that differs from
  // the first in trailing coordinates only. Energy is not available here.
  void begin_trailing(const Eigen::VectorXd& q, Eigen::Index held,
                      PotentialWorkspace& workspace) const;
  void evaluate_trailing(const Eigen::VectorXd& q, Eigen::Index held, unsigned want,
                         PotentialWorkspace& workspace, Evaluation& out) const;

  // The average of grad V on the segment from q0 to q1, exact because V is quartic: with m =
  // (q0+q1)/2, d = (q1-q0)/2:
  //  Lambda m + 3 C[m,m] + C[d,d] + 4 Q[m m^T + d d^T] m.
  // Hence out . (q1 - q0) = V(q1) - V(q0). tangent, if given, receives from the same contraction
  // Lambda + 6 C[m] + 12 Q[m m^T + d d^T] = K(m) + O(d^2), r x r, both triangles.
  void averaged_gradient(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                         PotentialWorkspace& workspace, Eigen::VectorXd& out,
                         Eigen::MatrixXd* tangent = nullptr) const;

  // The derivative of averaged_gradient with respect to q1, exact, symmetric:
  // 1/2 Lambda + 3 C[m] + C[d] + 6 Q[m m^T] + 2 Q[d d^T] + 2 Q[m d^T + d m^T].
  void averaged_jacobian(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                         PotentialWorkspace& workspace, Eigen::MatrixXd& out) const;

 private:
  struct Coefficients;
  const PairKernel& pair_kernel() const;
  void evaluate_linear(const Eigen::VectorXd& q, unsigned want, Evaluation& out) const;
  void evaluate_pairs(const Eigen::VectorXd& q, unsigned want, PotentialWorkspace& workspace,
                      Evaluation& out) const;
  void set_a(PotentialWorkspace& workspace) const;
  void set_a_and_b(PotentialWorkspace& workspace) const;
  void multiply_force_matrix(std::size_t first, PotentialWorkspace& workspace) const;
  void set_tangent(const PotentialWorkspace& workspace, Eigen::Index held,
                   Eigen::MatrixXd& out) const;

  Eigen::VectorXd lambda_;
  SymmetricKernel unique_;
  std::shared_ptr<const Coefficients> coefficients_;  // none if linear
};

}  // namespace tremolo
