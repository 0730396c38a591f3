#include "runtime/body.h"

#include <algorithm>
#include <cmath>
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

// Adds W f.
void add_response(const BasisRows& response, const Eigen::VectorXd& forces, std::span<double> out) {
  if (response.cols() == 0) return;
  for (std::size_t row = 0; row < out.size(); ++row)
    out[row] += response.row(static_cast<Eigen::Index>(row)).dot(forces);
}

Status check_frame(const Model& model, std::string_view method, FrameKind frame) {
  if (model.modes() == 0 && frame != FrameKind::kFree)
    return usage_error("a rigid body is free: hold it by pins, or use a collider that moves");
  if (frame == FrameKind::kFixed) return Success{};
  if (!kHasFrames)
    return usage_error("driven and free bodies are not in this module but in engine-full.wasm");
  const bool free = frame == FrameKind::kFree;
  const std::string what = free ? "a free body" : "a body whose support moves";
  if (!is_energy_method(method) && (free || (method != "newmark" && method != "imexv")))
    return usage_error(what + " is not moved by '" + std::string(method) +
                       "' but by avf, ep2, ep4" + (free ? "" : ", newmark and imexv"));
  if (model.inertia() == nullptr)
    return usage_error(what +
                       " needs the inertia integrals, which this basis file has not; make "
                       "it again with tremolo-precompute");
  if (free && model.rigid_mode_count() != 6)
    return usage_error(
        "a free body needs a basis that is held nowhere and in one piece; this one "
        "leaves out " +
        std::to_string(model.rigid_mode_count()) +
        " rigid motions instead of 6 (tremolo-precompute --fix none makes one)");
  if (!free && model.rigid_mode_count() != 0)
    return usage_error(
        "a body whose support moves needs a basis that is held somewhere "
        "(tremolo-precompute --fix); this one is free");
  return Success{};
}

}  // namespace

bool is_energy_method(std::string_view method) {
  return method == "avf" || method == "ep2" || method == "ep4";
}

Status check_state(Eigen::Index modes, const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  if (q.size() != modes || p.size() != modes)
    return usage_error("a state has " + std::to_string(modes) + " coordinates and momenta, got " +
                       std::to_string(q.size()) + " and " + std::to_string(p.size()));
  if (!q.allFinite() || !p.allFinite()) return usage_error("the state is not finite");
  return Success{};
}

Result<Body> Body::create(Model::Pointer model, std::string_view integrator,
                          const IntegratorOptions& wanted, FrameKind frame) {
  IntegratorOptions options = wanted;
  options.moving_frame = frame != FrameKind::kFixed;
  Result<std::unique_ptr<Integrator>> made = make_integrator(integrator, model, options);
  if (!made) return made.error();
  if (Status s = check_frame(*model, (*made)->name(), frame); !s) return s.error();
  const Result<Split> band = choose_split(model->lambda(), options.step, options.split);
  if (!band) return band.error();
  Body body(std::move(model), std::move(*made), options, band->low);
  body.begin_frame(frame);
  return body;
}

Result<Body> Body::create(Model::Pointer model, std::string_view integrator,
                          const IntegratorOptions& options, std::shared_ptr<const Skin> skin) {
  const auto fits = [&skin](const BoneWeights& weights, std::size_t points) {
    return std::cmp_equal(weights.rows(), points) && weights.cols() == std::ssize(skin->shares);
  };
  if (!skin || skin->shares.empty() || skin->shares.front()->modes() != model->modes() ||
      !fits(skin->drawn, model->drawn().rest.size()) ||
      !fits(skin->surface, model->surface().rest.size()))
    return usage_error("the skin was made for another model");
  Result<Body> body = create(std::move(model), integrator, options, FrameKind::kDriven);
  if (!body) return body;
  if constexpr (kHasFrames)
    body->driven_ = std::make_unique<DrivenFrame>(skin->shares, options.step);
  body->bone_maps_.resize(skin->bones());
  body->skin_ = std::move(skin);
  for (VertexId place : body->model().response_places()) {
    if (place == kAtDefaultLoad) place = body->model().default_load().vertices.front();
    const Result<std::span<const double>> weights = body->weights_of(place);
    if (!weights) return weights.error();
    body->place_weights_.emplace_back(Eigen::VectorXd::Map(weights->data(), std::ssize(*weights)));
  }
  return body;
}

Body::Body(Model::Pointer model, std::unique_ptr<Integrator> integrator,
           const IntegratorOptions& options, Eigen::Index low)
    : model_(std::move(model)),
      integrator_(std::move(integrator)),
      options_(options),
      state_{Eigen::VectorXd::Zero(model_->modes()), Eigen::VectorXd::Zero(model_->modes())},
      place_forces_(model_->response_places().size()),
      step_load_(make_step_load(model_->modes())),
      q_before_(state_.q),
      low_(low),
      sound_(state_),
      workspace_(model_->potential().make_workspace(kUsePoint)),
      evaluation_(model_->potential().make_evaluation()),
      evaluated_q_(state_.q.array() + std::numeric_limits<double>::quiet_NaN()),
      momentum_(state_.p) {}

Status Body::set_state(const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  if (Status s = check_state(model_->modes(), q, p); !s) return s;
  state_.q = q;
  state_.p = p;
  moved_ = true;
  if (free_) free_->set_motion(free_->rigid().velocity, free_->rigid().spin, q, p);
  integrator_->reset();
  bound_.start(total_energy());
  keep_sound_state();
  return Success{};
}

Status Body::add_load(const Load& load) {
  if (load.force.size() != model_->modes() || !load.force.allFinite())
    return usage_error("a reduced load has " + std::to_string(model_->modes()) +
                       " finite coordinates");
  if (free_) return usage_error("a free body takes forces on its vertices, not reduced ones");
  loads_.push_back(load);
  return Success{};
}

Status Body::add_load(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force) {
  return add_load(signal, DefaultLoad{{vertex}, {force}});
}

Status Body::add_load(const Signal& signal, const DefaultLoad& forces) {
  if (frame() == FrameKind::kFixed) {
    Result<Eigen::VectorXd> reduced = reduce_load(*model_, forces);
    if (!reduced) return reduced.error();
    if (Status s = add_load({signal, std::move(*reduced)}); !s) return s;
  } else {
    for (std::size_t i = 0; i < forces.vertices.size(); ++i)
      if (Status s = add_point_force(signal, forces.vertices[i], forces.forces[i], 0); !s) return s;
  }
  place_forces_.add(signal, *model_, forces, 0);
  return Success{};
}

Status Body::add_default_load(const Signal& signal, double scale) {
  if (model_->default_load().vertices.empty())
    return usage_error("the model carries no default load; name a vertex and a force");
  DefaultLoad load = model_->default_load();
  for (Eigen::Vector3d& force : load.forces) force *= scale;
  return add_load(signal, load);
}

void Body::clear_loads() {
  loads_.clear();
  applied_.clear();
  points_.clear();
  place_forces_.clear();
}

void Body::clear_forces() {
  applied_.clear();
  place_forces_.clear_applied();
  std::erase_if(points_, [](const PointForce& force) { return force.steps > 0; });
}

Status Body::apply_force(VertexId vertex, const Eigen::Vector3d& force, int steps) {
  if (steps < 1)
    return usage_error("a force acts for at least one step, got " + std::to_string(steps));
  if (frame() != FrameKind::kFixed) {
    if (Status s = add_point_force({}, vertex, force, steps); !s) return s;
  } else {
    Result<Eigen::VectorXd> reduced = reduce_force(*model_, vertex, force);
    if (!reduced) return reduced.error();
    applied_.push_back({std::move(*reduced), steps});
  }
  place_forces_.add({}, *model_, DefaultLoad{{vertex}, {force}}, steps);
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
  if (driven_ || free_) gather_frame();
}

void Body::age_applied_forces() {
  for (AppliedForce& applied : applied_) --applied.steps;
  std::erase_if(applied_, [](const AppliedForce& applied) { return applied.steps == 0; });
  // A force that acts for some steps ends with steps == -1, because 0 is one that its signal ends.
  for (PointForce& point : points_)
    if (point.steps > 0 && --point.steps == 0) point.steps = -1;
  std::erase_if(points_, [](const PointForce& point) { return point.steps < 0; });
}

bool Body::load_to_come() const {
  // As sample_signal does, an end within 1e-9 of a step from now counts as now.
  const double now = time() + 1e-9 * options_.step;
  const bool at_points = std::any_of(
      points_.begin(), points_.end(),
      [now](const PointForce& point) { return point.steps > 0 || signal_end(point.signal) > now; });
  return at_points || !applied_.empty() ||
         std::any_of(loads_.begin(), loads_.end(),
                     [now](const Load& load) { return signal_end(load.signal) > now; });
}

Energy Body::energy(std::optional<Eigen::Index> low) const {
  integrator_->synchronized_momentum(state_, momentum_);
  const Evaluation& here = at_state();
  return {frame_kinetic(momentum_), here.energy,
          band_energy(model_->lambda(), here.force, momentum_, low.value_or(low_))};
}

Result<Eigen::Vector3d> Body::displacement(VertexId vertex) const {
  const Result<VertexRows> rows = model_->vertex(vertex);
  if (!rows) return rows.error();
  const Eigen::Vector3d u = rows->rows * state_.q;
  if (place_forces_.none()) return u;
  const Result<VertexRows> response = model_->response(vertex);
  if (!response) return response.error();
  return Eigen::Vector3d(u + response->rows * place_forces_.now());
}

const Eigen::VectorXd& Body::shown() const {
  if (place_forces_.none()) return state_.q;
  shown_.resize(state_.q.size() + place_forces_.now().size());
  shown_ << state_.q, place_forces_.now();
  return shown_;
}

Status Body::surface_positions(std::span<double> out, SurfaceKind surface) const {
  const bool drawn = surface == SurfaceKind::kDrawn;
  const auto& rest = drawn ? model_->drawn().rest : model_->surface().rest;
  const BasisRows& rows = drawn ? model_->drawn().rows : model_->surface().rows;
  if (Status s = check_buffer(3 * rest.size(), out.size(), "positions"); !s) return s;
  write_positions(rest, rows, state_.q, out);
  add_response(drawn ? model_->drawn().response : model_->boundary_response(), place_forces_.now(),
               out);
  to_world(out, true, drawn ? &Skin::drawn : &Skin::surface);
  return Success{};
}

Status Body::surface(std::span<float> positions, std::span<float> normals) const {
  const std::size_t needed = drawn_numbers(*model_);
  if (Status s = check_buffer(needed, positions.size(), "positions"); !s) return s;
  if (normals.empty()) {
    tremolo::surface_positions(model_->surface_basis(), shown(), surface_, positions);
    to_world(positions, true, &Skin::drawn);
    return Success{};
  }
  if (Status s = check_buffer(needed, normals.size(), "normals"); !s) return s;
  surface_with_normals(model_->surface_basis(), model_->drawn().triangles, shown(), surface_,
                       positions, normals);
  to_world(positions, true, &Skin::drawn);
  to_world(normals, false, &Skin::drawn);
  return Success{};
}

// A ray ignores the shape W f, as a hand does.
std::optional<SurfaceTree::Hit> Body::nearest(const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction,
                                              SurfaceKind surface) const {
  if (bones() > 1) {
    const bool drawn = surface == SurfaceKind::kDrawn;
    const auto& rest = drawn ? model_->drawn().rest : model_->surface().rest;
    seen_places_.resize(3 * rest.size());
    write_positions(rest, drawn ? model_->drawn().rows : model_->surface().rows, state_.q,
                    seen_places_);
    to_world(std::span<double>(seen_places_), true, drawn ? &Skin::drawn : &Skin::surface);
    return nearest_of_all(drawn ? model_->drawn().triangles : model_->triangles(), seen_places_,
                          origin, direction);
  }
  const Pose pose = this->pose();
  const Eigen::Quaterniond back = pose.rotation.conjugate();
  return model_->surface_tree(surface).nearest(back * (origin - pose.position),
                                               (back * direction).normalized(), state_.q);
}

Result<std::optional<SurfaceHit>> Body::pick(const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction,
                                             SurfaceKind surface) const {
  if (!origin.allFinite() || !direction.allFinite())
    return usage_error("the ray's origin or direction is not finite");
  const double length = direction.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length))
    return usage_error("the ray's direction is zero or too long");
  const Eigen::Vector3d along = direction / length;
  const std::optional<SurfaceTree::Hit> found = nearest(origin, along, surface);
  if (!found) return std::optional<SurfaceHit>();
  SurfaceHit hit{{surface, found->triangle, found->weights}, 0, found->distance, {}};
  hit.vertex = model_->vertex_near(hit.place);
  hit.point = origin + found->distance * along;
  return std::optional<SurfaceHit>(hit);
}

}  // namespace tremolo
