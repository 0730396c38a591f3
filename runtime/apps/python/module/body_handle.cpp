#include "runtime/apps/python/module/body_handle.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "runtime/apps/python/module/world_parts.h"

namespace tremolo::python {

BodyHandle::BodyHandle(PyModelPointer model, BodyOptions options, ContactBody body)
    : model_(std::move(model)),
      own_(std::move(body)),
      body_(&*own_),
      used_(&own_used_),
      options_(std::move(options)),
      state_({py::ssize_t{2}, static_cast<py::ssize_t>(body_->model().modes())}) {
  pull_state();
}

BodyHandle::BodyHandle(PyModelPointer model, std::shared_ptr<void> world, ContactBody& body,
                       std::atomic<bool>& used)
    : model_(std::move(model)),
      world_(std::move(world)),
      body_(&body),
      used_(&used),
      state_({py::ssize_t{2}, static_cast<py::ssize_t>(body.model().modes())}) {
  pull_state();
}

BodyHandle::~BodyHandle() {
  if (body_ == nullptr || !in_world() || used_->load()) return;
  try {
    push_state();
  } catch (...) {  // what was written is not finite: the body stays as it is
  }
}

void refuse_removed(const std::string& name) {
  raise(usage_error("body '" + name + "' has been removed from its world"));
}

void BodyHandle::refuse_in_world(const char* what) const {
  if (in_world()) raise(usage_error(std::string("the body belongs to a world: ") + what));
}

void BodyHandle::push_state() {
  const State& state = body().state();
  const Eigen::Index r = state.q.size();
  if (r == 0) return;  // a rigid body: there is nothing to compare
  const double* q = state_.data();
  const double* p = q + r;
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(r);
  if (std::memcmp(q, state.q.data(), bytes) == 0 && std::memcmp(p, state.p.data(), bytes) == 0)
    return;
  const Status set = body_->set_state(Eigen::Map<const Eigen::VectorXd>(q, r),
                                      Eigen::Map<const Eigen::VectorXd>(p, r));
  if (set) return;
  pull_state();
  raise(set.error());
}

void BodyHandle::pull_state() {
  const State& state = body_->state();
  double* q = state_.mutable_data();
  std::copy_n(state.q.data(), state.q.size(), q);
  std::copy_n(state.p.data(), state.p.size(), q + state.q.size());
}

py::array BodyHandle::view_of(py::ssize_t row) {
  if (body_ == nullptr) refuse_removed(ended_);
  const py::capsule owner(new BodyPointer(shared_from_this()),
                          [](void* kept) { delete static_cast<BodyPointer*>(kept); });
  return py::array_t<double>(state_.shape(1), state_.mutable_data() + row * state_.shape(1), owner);
}

void BodyHandle::add_load(const BodyLoad& load) {
  BodyLoad kept = load;
  kept.signal.table = kept.table.get();
  if (const auto* reduced = std::get_if<Eigen::VectorXd>(&kept.force))
    check(body_->add_load(Load{kept.signal, *reduced}));
  else if (const auto* forces = std::get_if<DefaultLoad>(&kept.force))
    check(body_->add_load(kept.signal, *forces));
  else
    check(body_->add_default_load(kept.signal, std::get<double>(kept.force)));
  loads_.push_back(std::move(kept));
}

void BodyHandle::clear_loads() {
  body_->clear_loads();
  loads_.clear();
}

std::size_t BodyHandle::grab(const Grab& grab) {
  if (!in_world()) {
    enable_grabs();
    return unwrap(grab(body()));
  }
  SceneWorld& world = static_cast<WorldParts*>(world_.get())->world;
  std::size_t i = 0;
  while (&world.body(i) != &body()) ++i;
  return unwrap(world.hold_body(i, grab));
}

// A body alone meets no colliders; grabs need its contact all the same.
void BodyHandle::enable_grabs() {
  if (grabs_) return;
  ContactOptions options;
  options.colliders = false;
  check(body_->set_contact(options));
  grabs_ = true;
}

BodyPointer make_body(const PyModelPointer& model, const BodyOptions& options) {
  ContactBody body =
      unwrap(ContactBody::create(model->model, options.integrator, options.method, options.frame));
  return std::make_shared<BodyHandle>(model, options, std::move(body));
}

py::dict report_dict(const StepReport& report) {
  py::dict dict;
  dict["iterations"] = report.iterations;
  dict["residual"] = report.residual;
  dict["converged"] = report.converged;
  dict["dissipated"] = report.dissipated;
  dict["parts"] = report.parts;
  return dict;
}

}  // namespace tremolo::python
