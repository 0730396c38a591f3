// Many bodies: the force in lanes.
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <fmt/format.h>

#include "common/packed_index.h"
#include "runtime/bodies/lanes/lane_force.h"
#include "tests/lab/speed/speed_world.h"

namespace tremolo::bench {
namespace {

Eigen::VectorXd random_state(const Model& model, std::mt19937& random) {
  Eigen::Vector3d least = model.surface().rest[0], most = least;
  for (const Eigen::Vector3d& rest : model.surface().rest) {
    least = least.cwiseMin(rest);
    most = most.cwiseMax(rest);
  }
  double moved = 0.0;
  for (Eigen::Index row = 0; row + 2 < model.surface().rows.rows(); row += 3)
    moved = std::max(moved, model.surface().rows.block(row, 0, 3, 1).norm());
  // At 5 % some bodies of the samples would explode under imexv-linear at 1 ms.
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  Eigen::VectorXd q(model.modes());
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = uniform(random) * (most - least).maxCoeff() / moved *
           std::sqrt(model.lambda()[0] / model.lambda()[i]);
  return q;
}

template <class Real>
struct alignas(64) Row {
  Real value[kBodiesPerBlock<Real>];
};

// Blocks of lanes that hold the states.
template <class Real>
struct LaneField {
  LaneCoefficients<Real> coefficients;
  std::vector<Row<Real>> x, gradient;

  LaneField(const Model& model, const std::vector<Eigen::VectorXd>& states)
      : coefficients(make_lane_coefficients<Real>(static_cast<std::size_t>(model.modes()),
                                                  model.cubic(), model.quartic())) {
    const std::size_t r = coefficients.modes;
    x.resize((states.size() + kBodiesPerBlock<Real> - 1) / kBodiesPerBlock<Real> * r);
    gradient.resize(x.size());
    for (std::size_t b = 0; b < states.size(); ++b)
      for (std::size_t i = 0; i < r; ++i)
        x[b / kBodiesPerBlock<Real> * r + i].value[b % kBodiesPerBlock<Real>] =
            static_cast<Real>(states[b][i] / coefficients.coordinate_scale);
  }
  void evaluate(InstructionSet vectors = instruction_set()) {
    for (std::size_t at = 0; at < x.size(); at += coefficients.modes)
      evaluate_lanes(coefficients, x[at].value, gradient[at].value, nullptr, vectors);
  }
  // grad V of a body; lambda q added in double, as a Crowd does.
  Eigen::VectorXd force(const Model& model, const Eigen::VectorXd& q, std::size_t body) const {
    Eigen::VectorXd force = model.lambda().cwiseProduct(q);
    for (Eigen::Index i = 0; i < force.size(); ++i)
      force[i] += coefficients.energy_scale / coefficients.coordinate_scale *
                  static_cast<double>(gradient[body / kBodiesPerBlock<Real> * coefficients.modes +
                                               static_cast<std::size_t>(i)]
                                          .value[body % kBodiesPerBlock<Real>]);
    return force;
  }
};

// Two multiply-adds a quartic coefficient; a triple costs a product, three multiply-adds less the
// one that an addition is.
double operations_of_force(std::size_t r) {
  return 4.0 * static_cast<double>(quad_count(r)) + 6.0 * static_cast<double>(triple_count(r));
}

template <class Real>
SpeedRow force_row(const Model& model, double seconds, double baseline, double gflops,
                   double error) {
  const std::size_t r = model.modes();
  SpeedRow row = microseconds(
      fmt::format("force of one of {} bodies, r = {}, {} lanes", kBodies, r,
                  sizeof(Real) == 4 ? "f32" : "f64"),
      seconds / kBodies, baseline / kBodies,
      fmt::format("against Potential::evaluate a body; force differs by <= {:.1e} of |force|",
                  error));
  row.operations = operations_of_force(r);
  row.bytes = static_cast<double>((quad_count(r) + triple_count(r)) * sizeof(Real)) /
                  static_cast<double>(kBodiesPerBlock<Real>) +
              2.0 * static_cast<double>(r * sizeof(Real));
  row.limit = 1e-3 * row.operations / gflops;
  row.limited_by = "FMA peak";
  return row;
}

}  // namespace

std::vector<Eigen::VectorXd> random_states(const Model& model, std::size_t count) {
  std::mt19937 random(1);
  std::vector<Eigen::VectorXd> states;
  for (std::size_t b = 0; b < count; ++b) states.push_back(random_state(model, random));
  return states;
}

void measure_lane_force(const Model& model, const MachineProbe& probe, SpeedSection& section) {
  const std::vector<Eigen::VectorXd> states = random_states(model, kBodies);
  LaneField<float> floats(model, states);
  LaneField<double> doubles(model, states);
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  const std::vector<double> seconds =
      by_turns({[&] { floats.evaluate(); }, [&] { doubles.evaluate(); },
                [&] {
                  for (const Eigen::VectorXd& q : states)
                    model.potential().evaluate(q, kWantForce, workspace, evaluation);
                }},
               1, 40);
  double error_f32 = 0.0, error_f64 = 0.0;
  for (std::size_t b = 0; b < states.size(); ++b) {
    model.potential().evaluate(states[b], kWantForce, workspace, evaluation);
    const double size = evaluation.force.norm();
    error_f32 =
        std::max(error_f32, (floats.force(model, states[b], b) - evaluation.force).norm() / size);
    error_f64 =
        std::max(error_f64, (doubles.force(model, states[b], b) - evaluation.force).norm() / size);
  }
  section.rows.push_back(
      force_row<float>(model, seconds[0], seconds[2], probe.gflops_f32, error_f32));
  section.rows.push_back(force_row<double>(model, seconds[1], seconds[2], probe.gflops, error_f64));
}

void measure_narrower_lanes(const Model& model, SpeedSection& section) {
  if (instruction_set() != InstructionSet::kAvx512) return;
  const std::vector<Eigen::VectorXd> states = random_states(model, kBodies);
  LaneField<float> floats(model, states);
  LaneField<double> doubles(model, states);
  const std::vector<double> seconds =
      by_turns({[&] { floats.evaluate(InstructionSet::kAvx2); },
                [&] { doubles.evaluate(InstructionSet::kAvx2); }, [&] { floats.evaluate(); },
                [&] { doubles.evaluate(); }},
               1, 20);
  const char* names[] = {"f32", "f64"};
  for (std::size_t w = 0; w < 2; ++w) {
    SpeedRow row = microseconds(fmt::format("force of one of {} bodies, r = {}, {} lanes, AVX2",
                                            kBodies, model.modes(), names[w]),
                                seconds[w] / kBodies, seconds[2 + w] / kBodies,
                                "AVX2 code on this machine, against AVX-512");
    row.operations = operations_of_force(static_cast<std::size_t>(model.modes()));
    section.rows.push_back(std::move(row));
  }
}

}  // namespace tremolo::bench
