// The reduced model as used by the reference: V(q) = 1/2 q^T Lambda q + C[q,q,q] + Q[q,q,q,q] with
// unit mass, solved by the same steps as the full mesh (step_equation.h). Dense; intended for r up
// to about sixty.
#pragma once

#include "precompute/reference/full/step_equation.h"

namespace tremolo {

// cubic: pairs x r, C_ijk; quartic: pairs x pairs, Q_ijkl; rows and columns in the order of
// pair_index (common/packed_index.h), so that the first coordinates form a leading block. Both are
// empty for a linear model. strains: the Gram matrix of BasisData::strain_gram, whole; empty if it
// is not known: stiffness damping is then that of the rest shape.
struct ReducedModel {
  Vector lambda;
  Eigen::MatrixXd cubic, quartic;
  Eigen::MatrixXd strains = {};
  Eigen::Index size() const { return lambda.size(); }
};

// cubic, quartic: unique entries (packed_index.h) for at least r coordinates; empty: a linear
// model.
ReducedModel make_reduced_model(const Vector& lambda, const std::vector<double>& cubic,
                                const std::vector<double>& quartic,
                                const std::vector<double>& strain_gram = {});

// Returns the model of the first r coordinates.
ReducedModel first_coordinates(const ReducedModel& model, Eigen::Index r);

double reduced_energy(const ReducedModel& model, const Vector& q);  // J

// Return sum_i w_i R(q + s_i d) and its derivative with respect to d.
Vector reduced_force(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                     const Vector& q, const Vector& d);
Eigen::MatrixXd reduced_tangent(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                                const Vector& q, const Vector& d);

// Returns the interface for time integration and statics; it holds a reference to the model.
SecondOrderSystem make_system(const ReducedModel& model, SolveOptions options);

}  // namespace tremolo
