// tremolo_body_*: making, pushing, stepping and reading a body from C.

#include <algorithm>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "runtime/c/c_api.h"

namespace tremolo::c_api {

Result<tremolo_body_options> complete_body_options(const tremolo_body_options* given) {
  return complete(given, tremolo_body_options_init, "tremolo_body_options_init");
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

Result<FrameKind> to_frame(std::int32_t frame) {
  switch (frame) {
    case TREMOLO_FIXED:
      return FrameKind::kFixed;
    case TREMOLO_DRIVEN:
      return FrameKind::kDriven;
    case TREMOLO_FREE:
      return FrameKind::kFree;
    default:
      return usage_error("there is no frame " + std::to_string(frame) +
                         ": it is TREMOLO_FIXED, TREMOLO_DRIVEN or TREMOLO_FREE");
  }
}

}  // namespace tremolo::c_api

namespace {

using tremolo::ContactBody;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::need;
using tremolo::c_api::with;

// It views a string literal, which ends in a zero.
constexpr const char* kDefaultName = tremolo::kDefaultIntegrator.data();

template <class Real>
tremolo_status positions(const tremolo_body* body, Real* out, std::size_t length) noexcept {
  return with(body, {{out, "the buffer"}}, [&](const ContactBody& known) -> Status {
    const std::span<Real> numbers(out, length);
    if constexpr (std::is_same_v<Real, float>)
      return known.surface(numbers);
    else
      return known.surface_positions(numbers);
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
              .tolerance = defaults.tolerance,
              .frame = TREMOLO_FIXED,
              .reserved = 0};
}

tremolo_status tremolo_body_create(const tremolo_model* model, const tremolo_body_options* options,
                                   tremolo_body** body) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{model, "the model"}, {body, "the place for the body"}}); !s) return s;
    const Result<tremolo_body_options> full = tremolo::c_api::complete_body_options(options);
    if (!full) return full.error();
    const Result<tremolo::IntegratorOptions> integrator =
        tremolo::c_api::to_integrator_options(*full);
    if (!integrator) return integrator.error();
    const char* name = full->integrator == nullptr ? kDefaultName : full->integrator;
    const Result<tremolo::FrameKind> frame = tremolo::c_api::to_frame(full->frame);
    if (!frame) return frame.error();
    Result<ContactBody> made = ContactBody::create(model->pointer, name, *integrator, *frame);
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
  return with(body, {{force, "the force"}}, [&](ContactBody& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return known.apply_force(*id, Eigen::Vector3d(force), steps);
  });
}

tremolo_status tremolo_body_clear_forces(tremolo_body* body) {
  return with(body, [](ContactBody& known) -> Status {
    known.clear_forces();
    return Success{};
  });
}

tremolo_status tremolo_body_step(tremolo_body* body, int64_t count, int64_t* done) {
  if (done != nullptr) *done = 0;
  return with(body, [&](ContactBody& known) -> Status {
    if (count < 0) return tremolo::usage_error("the number of steps is " + std::to_string(count));
    for (int64_t step = 0; step < count; ++step) {
      const tremolo::StepReport report = known.step();
      if (!report.converged)
        return tremolo::Error{tremolo::error_kind(report.failure),
                              tremolo::why_not_made(report, known.time())};
      if (done != nullptr) *done = step + 1;
    }
    return Success{};
  });
}

double tremolo_body_time(const tremolo_body* body) {
  return body == nullptr ? 0.0 : body->body.time();
}

tremolo_status tremolo_body_state(const tremolo_body* body, double* q, double* p, size_t length) {
  return with(body, [&](const ContactBody& known) {
    return tremolo::c_api::copy_state(known.state(), q, p, length);
  });
}

tremolo_status tremolo_body_set_state(tremolo_body* body, const double* q, const double* p,
                                      size_t length) {
  return with(body, {{p, "the momenta"}}, [&](ContactBody& known) -> Status {
    const Eigen::Index r = known.model().modes();
    if (Status s = tremolo::c_api::need_buffer(q, length, static_cast<size_t>(r)); !s) return s;
    return known.set_state(Eigen::Map<const Eigen::VectorXd>(q, r),
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
  return with(body, {{positions, "the buffer for positions"}, {normals, "the buffer for normals"}},
              [&](const ContactBody& known) {
                return known.surface(std::span(positions, length), std::span(normals, length));
              });
}

tremolo_status tremolo_body_energy(const tremolo_body* body, double* kinetic, double* potential,
                                   double* high_band) {
  return with(body, [&](const ContactBody& known) -> Status {
    tremolo::c_api::copy_energy(known.energy(), kinetic, potential, high_band);
    return Success{};
  });
}

// tremolo_body_*: saving, putting back, other damping, from C.

namespace {}  // namespace

tremolo_status tremolo_body_save(const tremolo_body* body, void* bytes, size_t capacity,
                                 size_t* size) {
  return with(body, {{size, "the place for the size"}}, [&](const ContactBody& known) -> Status {
    const std::vector<std::byte> saved = known.save();
    if (bytes != nullptr) {
      if (capacity < saved.size())
        return tremolo::usage_error("the buffer holds " + std::to_string(capacity) +
                                    " bytes, the state takes " + std::to_string(saved.size()));
      std::copy(saved.begin(), saved.end(), static_cast<std::byte*>(bytes));
    }
    *size = saved.size();
    return Success{};
  });
}

tremolo_status tremolo_body_restore(tremolo_body* body, const void* bytes, size_t size) {
  return with(body, {{bytes, "the bytes"}}, [&](ContactBody& known) {
    return known.restore(std::span(static_cast<const std::byte*>(bytes), size));
  });
}

tremolo_status tremolo_body_set_damping(tremolo_body* body, double alpha, double beta) {
  return with(body, [&](ContactBody& known) { return known.set_damping(alpha, beta); });
}
