#include "precompute/reference/reduced_model.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "common/packed_index.h"
#include "precompute/dense/blas.h"

namespace tremolo {
namespace {

std::size_t index_of(Eigen::Index i) {
  return i;
}

// C[q] and Q[q,q] for each column of q, r x r each.
struct Contraction {
  Eigen::MatrixXd cubic, quartic;
};

std::vector<Contraction> contract(const ReducedModel& model, const Eigen::MatrixXd& q) {
  const Eigen::Index r = model.size(), points = q.cols();
  const Eigen::Index pairs = pair_count(index_of(r));
  Eigen::MatrixXd squares(pairs, points), cubic = Eigen::MatrixXd::Zero(pairs, points),
                                          quartic = cubic;
  for (Eigen::Index p = 0; p < points; ++p)
    for (Eigen::Index j = 0, row = 0; j < r; ++j)
      for (Eigen::Index i = 0; i <= j; ++i, ++row)
        squares(row, p) = (i == j ? 1.0 : 2.0) * q(i, p) * q(j, p);
  if (model.quartic.size() > 0) {
    add_product(1.0, model.cubic, q, 0.0, cubic);
    add_product(1.0, model.quartic, squares, 0.0, quartic);
  }
  std::vector<Contraction> result;
  for (Eigen::Index p = 0; p < points; ++p) {
    Contraction at{Eigen::MatrixXd(r, r), Eigen::MatrixXd(r, r)};
    for (Eigen::Index j = 0, row = 0; j < r; ++j)
      for (Eigen::Index i = 0; i <= j; ++i, ++row) {
        at.cubic(i, j) = at.cubic(j, i) = cubic(row, p);
        at.quartic(i, j) = at.quartic(j, i) = quartic(row, p);
      }
    result.push_back(std::move(at));
  }
  return result;
}

Eigen::MatrixXd positions(const std::vector<SegmentPoint>& points, const Vector& q,
                          const Vector& d) {
  Eigen::MatrixXd all(q.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) all.col(i) = q + points[i].fraction * d;
  return all;
}

Vector gradient_at(const ReducedModel& model, const StepEquation& equation, const Vector& d) {
  return reduced_force(model, equation.points, equation.origin, d) + equation.constant +
         equation.mass * d + equation.rest * model.lambda.cwiseProduct(d);
}

// The strain terms (packed_index.h) at q.
Vector strains_at(const Vector& q) {
  const auto r = index_of(q.size());
  Vector y(strain_terms(r));
  for (std::size_t j = 0; j < r; ++j) {
    y[strain_index(j)] = q[j];
    for (std::size_t i = 0; i <= j; ++i) y[strain_index(i, j)] = q[i] * q[j];
  }
  return y;
}

// Returns J^T s, J the derivative of the strain terms at q.
Vector pull_back(const Vector& q, const Vector& s) {
  const auto r = index_of(q.size());
  Vector force(r);
  for (std::size_t j = 0; j < r; ++j) force[j] = s[strain_index(j)];
  for (std::size_t j = 0; j < r; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      force[i] += s[strain_index(i, j)] * q[j];
      force[j] += s[strain_index(i, j)] * q[i];
    }
  return force;
}

// G times the change of the strain terms from q to q + d.
Vector changed_stress(const ReducedModel& model, const Vector& q, const Vector& d) {
  return model.strains * (strains_at(q + d) - strains_at(q));
}

Vector damping_force(const ReducedModel& model, const Vector& q, const Vector& d, double fraction) {
  if (model.strains.size() == 0) return model.lambda.cwiseProduct(d);
  return pull_back(q + fraction * d, changed_stress(model, q, d));
}

// Returns a factor of J, shifted by a multiple of the identity until it is positive definite.
Eigen::LLT<Eigen::MatrixXd> definite_factor(const Eigen::MatrixXd& jacobian) {
  Eigen::LLT<Eigen::MatrixXd> factor(jacobian);
  double shift = 1e-3 * jacobian.diagonal().cwiseAbs().maxCoeff();
  for (; factor.info() != Eigen::Success && std::isfinite(shift); shift *= 4)
    factor.compute(jacobian + shift * Eigen::MatrixXd::Identity(jacobian.rows(), jacobian.cols()));
  return factor;
}

SolveReport solve(const ReducedModel& model, const SolveOptions& options,
                  const StepEquation& equation, double energy, Vector& d) {
  constexpr double kStalled = 1e-7;
  SolveReport report;
  report.scale = std::sqrt(energy);
  Vector g = gradient_at(model, equation, d);
  for (double last = 0;; ++report.iterations) {
    if (!g.allFinite()) return report;
    Eigen::MatrixXd jacobian = reduced_tangent(model, equation.points, equation.origin, d);
    jacobian.diagonal().array() += equation.mass + equation.rest * model.lambda.array();
    const Eigen::LLT<Eigen::MatrixXd> factor = definite_factor(jacobian);
    Direction direction{-factor.solve(g), 0.0};
    ++report.factorisations;
    report.residual = std::sqrt(std::max(0.0, -g.dot(direction.step)));
    if (report.scale == 0) report.scale = report.residual;
    const double relative = report.scale == 0 ? 0.0 : report.residual / report.scale;
    const bool stalled = report.iterations > 1 && relative <= kStalled && report.residual > last;
    report.converged = relative <= options.tolerance || stalled;
    if (report.converged || report.iterations == options.max_iterations) return report;
    last = 0.5 * report.residual;
    direction.curvature = direction.step.dot(jacobian * direction.step);
    move_along([&](const Vector& at) { return gradient_at(model, equation, at); }, direction, d, g);
  }
}

}  // namespace

ReducedModel make_reduced_model(const Vector& lambda, const std::vector<double>& cubic,
                                const std::vector<double>& quartic,
                                const std::vector<double>& strain_gram) {
  ReducedModel model{lambda, {}, {}};
  if (quartic.empty()) return model;
  const auto r = index_of(lambda.size());
  const Eigen::Index pairs = pair_count(r);
  model.cubic.resize(pairs, lambda.size());
  model.quartic.resize(pairs, pairs);
  Eigen::Index row = 0;
  for (std::size_t j = 0; j < r; ++j)
    for (std::size_t i = 0; i <= j; ++i, ++row) {
      for (std::size_t k = 0; k < r; ++k) model.cubic(row, k) = cubic[triple_index_any(i, j, k)];
      Eigen::Index column = 0;
      for (std::size_t l = 0; l < r; ++l)
        for (std::size_t k = 0; k <= l; ++k, ++column)
          model.quartic(row, column) = quartic[quad_index_any(i, j, k, l)];
    }
  if (strain_gram.empty()) return model;
  const std::size_t terms = strain_terms(r);
  model.strains.resize(terms, terms);
  for (std::size_t b = 0; b < terms; ++b)
    for (std::size_t a = 0; a <= b; ++a)
      model.strains(a, b) = model.strains(b, a) = strain_gram[pair_index(a, b)];
  return model;
}

ReducedModel first_coordinates(const ReducedModel& model, Eigen::Index r) {
  ReducedModel first{model.lambda.head(r), {}, {}};
  if (model.quartic.size() == 0) return first;
  const Eigen::Index pairs = pair_count(index_of(r));
  first.cubic = model.cubic.topLeftCorner(pairs, r);
  first.quartic = model.quartic.topLeftCorner(pairs, pairs);
  const Eigen::Index terms = strain_terms(index_of(r));
  if (model.strains.size() > 0) first.strains = model.strains.topLeftCorner(terms, terms);
  return first;
}

double reduced_energy(const ReducedModel& model, const Vector& q) {
  const Contraction at = contract(model, q).front();
  return 0.5 * q.dot(model.lambda.cwiseProduct(q)) + q.dot((at.cubic + at.quartic) * q);
}

Vector reduced_force(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                     const Vector& q, const Vector& d) {
  const Eigen::MatrixXd at = positions(points, q, d);
  const std::vector<Contraction> contractions = contract(model, at);
  Vector force = Vector::Zero(q.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].rate) {
      force += points[i].weight * damping_force(model, q, d, points[i].fraction);
      continue;
    }
    const Vector here = at.col(i);
    force +=
        points[i].weight * (model.lambda.cwiseProduct(here) +
                            (3.0 * contractions[i].cubic + 4.0 * contractions[i].quartic) * here);
  }
  return force;
}

Eigen::MatrixXd reduced_tangent(const ReducedModel& model, const std::vector<SegmentPoint>& points,
                                const Vector& q, const Vector& d) {
  const std::vector<Contraction> contractions = contract(model, positions(points, q, d));
  Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(q.size(), q.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Of stiffness damping the tangent at the point: it differs by the stress there.
    const double weight = points[i].weight * (points[i].rate ? 1.0 : points[i].fraction);
    tangent += weight * (6.0 * contractions[i].cubic + 12.0 * contractions[i].quartic);
    tangent.diagonal() += weight * model.lambda;
  }
  return tangent;
}

SecondOrderSystem make_system(const ReducedModel& model, SolveOptions options) {
  return {model.size(), [](const Vector& x) { return x; },
          [&model](const Vector& q, const Vector& d) {
            if (model.strains.size() == 0) return d.dot(model.lambda.cwiseProduct(d));
            return changed_stress(model, q, d).dot(strains_at(q + d) - strains_at(q));
          },
          [&model](const Vector& q) { return reduced_energy(model, q); },
          [&model, options](const StepEquation& equation, double energy, Vector& d) {
            return solve(model, options, equation, energy, d);
          }};
}

}  // namespace tremolo
