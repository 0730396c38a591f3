#include "runtime/body.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace tremolo {
namespace {

// what: "positions" or "normals".
Status check_buffer(std::size_t needed, std::size_t size, const char* what) {
  if (size == needed) return Success{};
  return usage_error(std::string("the buffer for ") + what + " holds " + std::to_string(size) +
                     " numbers, needs " + std::to_string(needed));
}

std::size_t drawn_numbers(const Model& model) {
  return 3 * model.drawn().rest.size();
}

// Row by row: a whole product would need a temporary.
void write_positions(const std::vector<Eigen::Vector3d>& rest, const BasisRows& rows,
                     const Eigen::VectorXd& q, std::span<double> out) {
  for (std::size_t row = 0; row < out.size(); ++row)
    out[row] = rest[row / 3][static_cast<Eigen::Index>(row % 3)] +
               rows.row(static_cast<Eigen::Index>(row)).dot(q);
}

}  // namespace

Status check_state(Eigen::Index modes, const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  if (q.size() != modes || p.size() != modes)
    return usage_error("a state has " + std::to_string(modes) + " coordinates and momenta, got " +
                       std::to_string(q.size()) + " and " + std::to_string(p.size()));
  if (!q.allFinite() || !p.allFinite()) return usage_error("the state is not finite");
  return Success{};
}

Result<Body> Body::create(Model::Pointer model, std::string_view integrator,
                          const IntegratorOptions& options) {
  Result<std::unique_ptr<Integrator>> made = make_integrator(integrator, model, options);
  if (!made) return made.error();
  const Result<Split> band = choose_split(model->lambda(), options.step, options.split);
  if (!band) return band.error();
  return Body(std::move(model), std::move(*made), options, band->low);
}

Body::Body(Model::Pointer model, std::unique_ptr<Integrator> integrator,
           const IntegratorOptions& options, Eigen::Index low)
    : model_(std::move(model)),
      integrator_(std::move(integrator)),
      options_(options),
      low_(low),
      state_{Eigen::VectorXd::Zero(model_->modes()), Eigen::VectorXd::Zero(model_->modes())},
      step_load_(make_step_load(model_->modes())),
      q_before_(state_.q),
      sound_(state_),
      workspace_(model_->potential().make_workspace(kUsePoint)),
      evaluation_(model_->potential().make_evaluation()),
      momentum_(state_.p) {}

Status Body::set_state(const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  if (Status s = check_state(model_->modes(), q, p); !s) return s;
  state_.q = q;
  state_.p = p;
  integrator_->reset();
  bound_.start(total_energy());
  keep_sound_state();
  return Success{};
}

Status Body::add_load(const Load& load) {
  if (load.force.size() != model_->modes() || !load.force.allFinite())
    return usage_error("a reduced load has " + std::to_string(model_->modes()) +
                       " finite coordinates");
  loads_.push_back(load);
  return Success{};
}

Status Body::add_load(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force) {
  Result<Eigen::VectorXd> reduced = reduce_force(*model_, vertex, force);
  if (!reduced) return reduced.error();
  return add_load({signal, std::move(*reduced)});
}

Status Body::add_default_load(const Signal& signal, double scale) {
  if (model_->default_load().vertices.empty())
    return usage_error("the model carries no default load; name a vertex and a force");
  Result<Eigen::VectorXd> reduced = reduce_load(*model_, model_->default_load(), scale);
  if (!reduced) return reduced.error();
  return add_load({signal, std::move(*reduced)});
}

void Body::clear_loads() {
  loads_.clear();
  applied_.clear();
}

void Body::clear_forces() {
  applied_.clear();
}

Status Body::apply_force(VertexId vertex, const Eigen::Vector3d& force, int steps) {
  if (steps < 1)
    return usage_error("a force acts for at least one step, got " + std::to_string(steps));
  Result<Eigen::VectorXd> reduced = reduce_force(*model_, vertex, force);
  if (!reduced) return reduced.error();
  applied_.push_back({std::move(*reduced), steps});
  return Success{};
}

void Body::gather_loads() {
  sample_loads(loads_, time(), options_.step, step_load_);
  for (const AppliedForce& applied : applied_) {
    step_load_.start += applied.force;
    step_load_.average += applied.force;
    step_load_.end += applied.force;
    step_load_.active = true;
  }
}

void Body::age_applied_forces() {
  for (AppliedForce& applied : applied_) --applied.steps;
  std::erase_if(applied_, [](const AppliedForce& applied) { return applied.steps == 0; });
}

bool Body::load_to_come() const {
  // As sample_signal does, an end within 1e-9 of a step from now counts as now.
  const double now = time() + 1e-9 * options_.step;
  return !applied_.empty() || std::any_of(loads_.begin(), loads_.end(), [now](const Load& load) {
    return signal_end(load.signal) > now;
  });
}

Energy Body::energy(Eigen::Index low) const {
  integrator_->synchronized_momentum(state_, momentum_);
  model_->potential().evaluate(state_.q, kWantEnergy | kWantForce, workspace_, evaluation_);
  return {kinetic_energy(momentum_), evaluation_.energy,
          band_energy(model_->lambda(), evaluation_.force, momentum_, low)};
}

Result<Eigen::Vector3d> Body::displacement(VertexId vertex) const {
  const Result<VertexRows> rows = model_->vertex(vertex);
  if (!rows) return rows.error();
  return Eigen::Vector3d(rows->rows * state_.q);
}

Status Body::surface_positions(std::span<double> out) const {
  if (Status s = check_buffer(drawn_numbers(*model_), out.size(), "positions"); !s) return s;
  const DrawnSurface drawn = model_->drawn();
  write_positions(drawn.rest, drawn.rows, state_.q, out);
  return Success{};
}

Status Body::boundary_positions(std::span<double> out) const {
  const VertexBlock& surface = model_->surface();
  if (Status s = check_buffer(3 * surface.rest.size(), out.size(), "positions"); !s) return s;
  write_positions(surface.rest, surface.rows, state_.q, out);
  return Success{};
}

Status Body::surface_positions(std::span<float> out) const {
  if (Status s = check_buffer(drawn_numbers(*model_), out.size(), "positions"); !s) return s;
  tremolo::surface_positions(model_->surface_basis(), state_.q, surface_, out);
  return Success{};
}

Status Body::surface(std::span<float> positions, std::span<float> normals) const {
  const std::size_t needed = drawn_numbers(*model_);
  if (Status s = check_buffer(needed, positions.size(), "positions"); !s) return s;
  if (Status s = check_buffer(needed, normals.size(), "normals"); !s) return s;
  surface_with_normals(model_->surface_basis(), model_->drawn().triangles, state_.q, surface_,
                       positions, normals);
  return Success{};
}

}  // namespace tremolo
