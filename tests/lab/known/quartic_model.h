// Small models written by hand: a Model from a quartic polynomial instead of a basis file.
//
//     V(q) = 1/2 q^T Lambda q + sum of monomials of degree three and four
#pragma once

#include <cstddef>
#include <string_view>

#include <Eigen/Core>

#include "formats/basis/basis_data.h"
#include "runtime/integrator.h"

namespace tremolo::known {

// The value used for zero in lambda where V has no quadratic part along a coordinate: a model
// demands a positive number, (rad/s)^2. With |q| near 1 it adds 5e-13 to the energy.
inline constexpr double kNoStiffness = 1e-12;

// lambda: r, positive, ascending. No vertices, no cubic or quartic part yet.
BasisData quadratic_basis(const Eigen::VectorXd& lambda);

// Adds coefficient * q_i q_j q_k or coefficient * q_i q_j q_k q_l to V; i <= j <= k <= l.
void add_monomial(BasisData& data, double coefficient, std::size_t i, std::size_t j, std::size_t k);
void add_monomial(BasisData& data, double coefficient, std::size_t i, std::size_t j, std::size_t k,
                  std::size_t l);

// Adds coefficient * (c . q)^3 or (c . q)^4. c: r.
void add_cube(BasisData& data, double coefficient, const Eigen::VectorXd& c);
void add_fourth_power(BasisData& data, double coefficient, const Eigen::VectorXd& c);

// V(q) of a model.
double potential_energy(const Model& model, const Eigen::VectorXd& q);

// R(q) = grad V.
Eigen::VectorXd potential_force(const Model& model, const Eigen::VectorXd& q);

// H = |p|^2/2 + V(q), p at the time of q.
double total_energy(const Model& model, const Integrator& integrator, const State& state);

}  // namespace tremolo::known
