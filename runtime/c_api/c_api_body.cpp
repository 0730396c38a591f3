// tremolo_body_*: making, pushing, stepping and reading a body from C.
#include <algorithm>
#include <cstring>
#include <span>

#include "runtime/c_api/c_api.h"

namespace tremolo::c_api {

Result<tremolo_body_options> complete_options(const tremolo_body_options* given) {
  tremolo_body_options options;
  tremolo_body_options_init(&options);
  if (given == nullptr) return options;
  std::uint32_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size < sizeof(size))
    return usage_error("the options' size is " + std::to_string(size) +
                       "; call tremolo_body_options_init first");
  std::memcpy(&options, given, std::min<std::size_t>(size, sizeof(options)));
  return options;
}

Result<IntegratorOptions> to_integrator_options(const tremolo_body_options& options) {
  IntegratorOptions result;
  Result<SplitOptions> split = parse_split(options.split == nullptr ? "default" : options.split);
  if (!split) return split.error();
  result.split = *split;
  result.split.safety = options.safety;
  result.step = options.step;
  result.alpha = options.alpha;
  result.beta = options.beta;
  result.newmark_beta = options.newmark_beta;
  result.newmark_gamma = options.newmark_gamma;
  result.tolerance = options.tolerance;
  result.max_iterations = options.max_iterations;
  return result;
}

}  // namespace tremolo::c_api

namespace {

using tremolo::Error;
using tremolo::ErrorKind;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::guarded;
using tremolo::c_api::need;
using tremolo::c_api::need_buffer;
using tremolo::c_api::usage_error;

// It views a string literal, which ends in a zero.
constexpr const char* kDefaultName = tremolo::kDefaultIntegrator.data();

template <class Real>
tremolo_status positions(const tremolo_body* body, Real* out, std::size_t length) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    if (Status s = need(out, "the buffer"); !s) return s;
    return body->body.surface_positions(std::span<Real>(out, length));
  });
}

}  // namespace

const char* tremolo_integrator_name(size_t index) {
  const auto names = tremolo::integrator_names();
  // The table holds string literals, which end in a zero.
  return index < names.size() ? names[index].data() : nullptr;
}

void tremolo_body_options_init(tremolo_body_options* options) {
  if (options == nullptr) return;
  const tremolo::IntegratorOptions defaults;
  *options = {.size = sizeof(tremolo_body_options),
              .max_iterations = defaults.max_iterations,
              .integrator = kDefaultName,
              .split = "default",
              .step = defaults.step,
              .alpha = defaults.alpha,
              .beta = defaults.beta,
              .newmark_beta = defaults.newmark_beta,
              .newmark_gamma = defaults.newmark_gamma,
              .safety = defaults.split.safety,
              .tolerance = defaults.tolerance};
}

tremolo_status tremolo_body_create(const tremolo_model* model, const tremolo_body_options* options,
                                   tremolo_body** body) {
  return guarded([&]() -> Status {
    if (Status s = need(model, "the model"); !s) return s;
    if (Status s = need(body, "the place for the body"); !s) return s;
    const tremolo::Result<tremolo_body_options> full = tremolo::c_api::complete_options(options);
    if (!full) return full.error();
    const tremolo::Result<tremolo::IntegratorOptions> integrator =
        tremolo::c_api::to_integrator_options(*full);
    if (!integrator) return integrator.error();
    const char* name = full->integrator == nullptr ? kDefaultName : full->integrator;
    tremolo::Result<tremolo::Body> made = tremolo::Body::create(model->pointer, name, *integrator);
    if (!made) return made.error();
    *body = new tremolo_body{std::move(*made)};
    return Success{};
  });
}

void tremolo_body_destroy(tremolo_body* body) {
  delete body;
}

tremolo_status tremolo_body_apply_force(tremolo_body* body, uint32_t vertex, const double force[3],
                                        int32_t steps) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    if (Status s = need(force, "the force"); !s) return s;
    if (!std::in_range<tremolo::VertexId>(vertex))
      return usage_error("the model has no vertex " + std::to_string(vertex));
    return body->body.apply_force(static_cast<tremolo::VertexId>(vertex),
                                  Eigen::Vector3d(force[0], force[1], force[2]), steps);
  });
}

tremolo_status tremolo_body_clear_forces(tremolo_body* body) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    body->body.clear_forces();
    return Success{};
  });
}

tremolo_status tremolo_body_step(tremolo_body* body, int64_t count, int64_t* done) {
  if (done != nullptr) *done = 0;
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    if (count < 0) return usage_error("the number of steps is " + std::to_string(count));
    for (int64_t step = 0; step < count; ++step) {
      const tremolo::StepReport report = body->body.step();
      if (!report.converged)
        return Error{tremolo::error_kind(report.failure),
                     tremolo::why_not_made(report, body->body.time())};
      if (done != nullptr) *done = step + 1;
    }
    return Success{};
  });
}

double tremolo_body_time(const tremolo_body* body) {
  return body == nullptr ? 0.0 : body->body.time();
}

tremolo_status tremolo_body_state(const tremolo_body* body, double* q, double* p, size_t length) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    const tremolo::State& state = body->body.state();
    if (Status s = need_buffer(q, length, static_cast<size_t>(state.q.size())); !s) return s;
    std::copy(state.q.begin(), state.q.end(), q);
    if (p != nullptr) std::copy(state.p.begin(), state.p.end(), p);
    return Success{};
  });
}

tremolo_status tremolo_body_set_state(tremolo_body* body, const double* q, const double* p,
                                      size_t length) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    if (Status s = need(p, "the momenta"); !s) return s;
    const Eigen::Index r = body->body.model().modes();
    if (Status s = need_buffer(q, length, static_cast<size_t>(r)); !s) return s;
    return body->body.set_state(Eigen::Map<const Eigen::VectorXd>(q, r),
                                Eigen::Map<const Eigen::VectorXd>(p, r));
  });
}

tremolo_status tremolo_body_positions_float(const tremolo_body* body, float* out, size_t length) {
  return positions(body, out, length);
}

tremolo_status tremolo_body_positions_double(const tremolo_body* body, double* out, size_t length) {
  return positions(body, out, length);
}

tremolo_status tremolo_body_surface_float(const tremolo_body* body, float* positions,
                                          float* normals, size_t length) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    if (Status s = need(positions, "the buffer for positions"); !s) return s;
    if (Status s = need(normals, "the buffer for normals"); !s) return s;
    return body->body.surface(std::span(positions, length), std::span(normals, length));
  });
}

tremolo_status tremolo_body_energy(const tremolo_body* body, double* kinetic, double* potential,
                                   double* high_band) {
  return guarded([&]() -> Status {
    if (Status s = need(body, "the body"); !s) return s;
    const tremolo::Energy energy = body->body.energy();
    if (kinetic != nullptr) *kinetic = energy.kinetic;
    if (potential != nullptr) *potential = energy.potential;
    if (high_band != nullptr) *high_band = energy.high_band;
    return Success{};
  });
}
