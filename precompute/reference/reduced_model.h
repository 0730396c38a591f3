// A reduced model as the reference wants it: V(q) = 1/2 q^T Lambda q + C[q,q,q] + Q[q,q,q,q], mass
// the identity, solved by the same steps as the full mesh (step_equation.h). Dense; made for r up
// to about sixty.
#pragma once

#include "precompute/reference/step_equation.h"

namespace tremolo {

// cubic: pairs x r, C_ijk; quartic: pairs x pairs, Q_ijkl; rows and columns in the order of
// pair_index (common/packed_index.h), so the first coordinates are a leading block. Both are empty
// for a linear model.
struct ReducedModel {
  Vector lambda;
  Eigen::MatrixXd cubic, quartic;
  Eigen::Index size() const { return lambda.size(); }
};

// cubic, quartic: unique entries (packed_index.h) of at least r coordinates; empty: a linear model.
ReducedModel make_reduced_model(const Vector& lambda, const std::vector<double>& cubic,
                                const std::vector<double>& quartic);

// The model of the first r coordinates.
ReducedModel first_coordinates(const ReducedModel& model, Eigen::Index r);

double reduced_energy(const ReducedModel& model, const Vector& q);  // J

// sum_i w_i R(q + s_i d) and its derivative by d.
Vector reduced_force(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                     const Vector& q, const Vector& d);
Eigen::MatrixXd reduced_tangent(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                                const Vector& q, const Vector& d);

// Borrows the model.
SecondOrderSystem make_system(const ReducedModel& model, SolveOptions options);

}  // namespace tremolo
