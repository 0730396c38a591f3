#include "runtime/load.h"

#include <cmath>
#include <string>

#include "common/text.h"

namespace tremolo {

StepLoad make_step_load(Eigen::Index modes) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(modes);
  return {zero, zero, zero};
}

void sample_loads(const std::vector<Load>& loads, double time, double step, StepLoad& out) {
  out.start.setZero();
  out.average.setZero();
  out.end.setZero();
  out.active = false;
  for (const Load& load : loads) {
    const StepSignal sample = sample_signal(load.signal, time, step);
    if (sample.start == 0.0 && sample.average == 0.0 && sample.end == 0.0) continue;
    out.start += sample.start * load.force;
    out.average += sample.average * load.force;
    out.end += sample.end * load.force;
    out.active = true;
  }
}

void load_at(const StepLoad& load, double s, Eigen::VectorXd& out) {
  // f0 (1 - s) + f1 s + c s (1 - s) has the average (f0 + f1)/2 + c/6.
  const double bend = 6.0 * s * (1.0 - s);
  out = (1.0 - s - 0.5 * bend) * load.start + (s - 0.5 * bend) * load.end + bend * load.average;
}

void restrict_load(const StepLoad& load, double a, double b, StepLoad& out) {
  load_at(load, a, out.start);
  load_at(load, b, out.end);
  const double middle = 0.5 * (a + b);
  const double bend = 6.0 * (middle - (a * a + a * b + b * b) / 3.0);  // of s (1 - s), averaged
  out.average = (1.0 - middle - 0.5 * bend) * load.start + (middle - 0.5 * bend) * load.end +
                bend * load.average;
  out.active = load.active;
  out.coupling = load.coupling;
}

Result<Eigen::VectorXd> reduce_force(const Model& model, VertexId vertex,
                                     const Eigen::Vector3d& force) {
  if (!force.allFinite()) return usage_error("the force is not finite");
  const Result<VertexRows> rows = model.vertex(vertex);
  if (!rows) return rows.error();
  Eigen::VectorXd reduced = rows->rows.transpose() * force;
  if (!std::isfinite(reduced.squaredNorm()))
    return usage_error("the force of " + number_text(force.lpNorm<Eigen::Infinity>()) +
                       " N at vertex " + std::to_string(vertex) +
                       " is too large to be reckoned with");
  return reduced;
}

Result<Eigen::VectorXd> reduce_load(const Model& model, const DefaultLoad& load, double scale) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model.modes());
  for (std::size_t i = 0; i < load.vertices.size(); ++i) {
    const Result<Eigen::VectorXd> one =
        reduce_force(model, load.vertices[i], scale * load.forces[i]);
    if (!one) return one.error();
    sum += *one;
  }
  return sum;
}

}  // namespace tremolo
