#include "tests/lab/known/quartic_model.h"

#include <algorithm>

#include "common/packed_index.h"

namespace tremolo::known {

BasisData quadratic_basis(const Eigen::VectorXd& lambda) {
  BasisData data;
  const std::size_t r = lambda.size();
  data.lambda = lambda;
  data.linear_mode_count = r;
  data.cubic.assign(triple_count(r), 0.0);
  data.quartic.assign(quad_count(r), 0.0);
  data.surface.rows.resize(0, lambda.size());
  data.interior.rows.resize(0, lambda.size());
  data.provenance = "{}";
  return data;
}

void add_monomial(BasisData& data, double coefficient, std::size_t i, std::size_t j,
                  std::size_t k) {
  data.cubic[triple_index(i, j, k)] += coefficient / orderings(i, j, k);
}

void add_monomial(BasisData& data, double coefficient, std::size_t i, std::size_t j, std::size_t k,
                  std::size_t l) {
  data.quartic[quad_index(i, j, k, l)] += coefficient / orderings(i, j, k, l);
}

void add_cube(BasisData& data, double coefficient, const Eigen::VectorXd& c) {
  std::size_t at = 0;
  for (Eigen::Index k = 0; k < c.size(); ++k)
    for (Eigen::Index j = 0; j <= k; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) data.cubic[at++] += coefficient * c[i] * c[j] * c[k];
}

void add_fourth_power(BasisData& data, double coefficient, const Eigen::VectorXd& c) {
  std::size_t at = 0;
  for (Eigen::Index l = 0; l < c.size(); ++l)
    for (Eigen::Index k = 0; k <= l; ++k)
      for (Eigen::Index j = 0; j <= k; ++j)
        for (Eigen::Index i = 0; i <= j; ++i)
          data.quartic[at++] += coefficient * c[i] * c[j] * c[k] * c[l];
}

double potential_energy(const Model& model, const Eigen::VectorXd& q) {
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  model.potential().evaluate(q, kWantEnergy, workspace, evaluation);
  return evaluation.energy;
}

Eigen::VectorXd potential_force(const Model& model, const Eigen::VectorXd& q) {
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  model.potential().evaluate(q, kWantForce, workspace, evaluation);
  return evaluation.force;
}

double total_energy(const Model& model, const Integrator& integrator, const State& state) {
  Eigen::VectorXd momentum = state.p;
  integrator.synchronized_momentum(state, momentum);
  return 0.5 * momentum.squaredNorm() + potential_energy(model, state.q);
}

}  // namespace tremolo::known
