// The textbook method of evaluating a reduced StVK model, as a baseline: every reduced force and
// every entry of the tangent is a polynomial of its own (Barbic and James 2005, section 4.2), kept
// as dense tables over the monomials of degree one, two and three, and evaluated by BLAS
// matrix-vector products.
#pragma once

#include <memory>
#include <string>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"

namespace tremolo::bench {

// BLAS's y <- A x, A column-major; Eigen's own where no BLAS library is installed.
struct MatrixVector;

class Textbook {
 public:
  explicit Textbook(const Potential& potential);
  ~Textbook();
  Textbook(Textbook&&) noexcept;

  std::string blas() const;     // which library multiplies
  std::size_t doubles() const;  // of all tables

  void force(const Eigen::VectorXd& q);                           // fills force_
  void force_and_tangent(const Eigen::VectorXd& q, bool energy);  // and tangent_, both triangles

  const Eigen::VectorXd& force_value() const { return force_; }
  const Eigen::MatrixXd& tangent_value() const { return tangent_; }
  double energy_value() const { return energy_; }

 private:
  void fill_monomials(const Eigen::VectorXd& q, bool third);

  Eigen::Index r_;
  Eigen::MatrixXd force1_, force2_, force3_;        // r x r, r x pairs, r x triples
  Eigen::MatrixXd tangent0_, tangent1_, tangent2_;  // pairs x 1, pairs x r, pairs x pairs
  Eigen::VectorXd quadratic_, cubic_;               // monomials
  Eigen::VectorXd parts_[3];                        // of the force, by degree
  Eigen::VectorXd force_, packed_;
  Eigen::MatrixXd tangent_;
  double energy_ = 0.0;
  std::shared_ptr<const MatrixVector> multiply_;
};

// One Newmark step (beta 1/4, gamma 1/2, undamped, unloaded) with the textbook's force and tangent:
// full Newton, each correction by a fresh Cholesky factor, to |residual| <= tolerance (the measure
// of runtime/bodies/reduced/integrators/newmark.cpp). Returns the evaluations, negative if it did
// not converge.
int textbook_newmark_step(Textbook& textbook, double step, double tolerance, Eigen::VectorXd& q,
                          Eigen::VectorXd& v, Eigen::VectorXd& a);

// One step of central differences, v at the half step.
void textbook_central_difference_step(Textbook& textbook, double step, Eigen::VectorXd& q,
                                      Eigen::VectorXd& v);

}  // namespace tremolo::bench
