#include "runtime/bodies/cloth/cloth_body.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/step/halved_step.h"

namespace tremolo {

using Eigen::Vector3d;
using Eigen::VectorXd;

Result<ClothModel> make_cloth_model(const SceneCloth& cloth) {
  Result<ClothParts> parts = make_cloth_parts(cloth);
  if (!parts) return parts.error();
  Result<ClothModel> model = ClothModel::create(std::move(*parts));
  if (!model) return model;
  for (const ClothPin& pin : cloth.pins) {
    Result<MotionPath> path = MotionPath::create(pin.motion);
    if (!path) return path.error();
    const ClothParts& made = model->parts();
    std::vector<std::size_t> particles;
    for (const std::size_t vertex : pin.particles) {
      if (vertex >= made.vertices())
        return content_error("pins: there is no vertex " + std::to_string(vertex) + ": there are " +
                             std::to_string(made.vertices()));
      particles.push_back(made.particle_of_vertex(vertex));
    }
    if (Status s = model->pin(particles, std::move(*path), pin.until); !s) return s.error();
  }
  return model;
}

Vector3d wind_at(const ClothScene& scene, double time) {
  return scene.wind * (1.0 + scene.gust * std::sin(2.0 * M_PI * scene.gust_hz * time));
}

Result<ClothBody> ClothBody::create(const ClothScene& scene, const Vector3d& velocity,
                                    const Vector3d& spin) {
  if (Status s = check_scene(scene); !s) return s.error();
  ClothBody body(scene);
  const SceneCloth& cloth = body.cloth();
  const auto of_cloth = [&cloth](const Error& error) {
    return Error{error.kind, "cloth '" + cloth.name + "': " + error.message};
  };
  if (!velocity.allFinite()) return of_cloth(content_error("its velocity is not finite"));
  if (!spin.allFinite()) return of_cloth(content_error("its spin is not finite"));
  if (Status s = check_start_size(cloth.position, velocity, spin); !s) return of_cloth(s.error());
  if (!spin.isZero(0.0) && !cloth.pins.empty())
    return of_cloth(content_error(
        "its pins hold it, so that it cannot spin: leave `spin` or `pins` out, or move the pins by "
        "a `motion` of the kind \"spin\""));
  if (cloth.settled && !(velocity.isZero(0.0) && spin.isZero(0.0)))
    return of_cloth(
        content_error("it has a velocity or a spin, but start = \"static\" means at rest: leave "
                      "one of both out"));
  Result<ClothModel> model = make_cloth_model(cloth);
  if (!model) return of_cloth(model.error());
  body.model_ = std::make_unique<ClothModel>(std::move(*model));
  const double h = scene.options.step;
  body.model_->set_gravity(scene.gravity.at(0.5 * h));
  const auto held = body.model_->held();
  NodalState& state = body.state_;
  state.x = crumpled(body.model_->parts(), cloth.crumple, {held.begin(), held.end()});
  body.model_->put_held(0.0, state.x);
  state.v = VectorXd::Zero(state.x.size());
  Vector3d centre = Vector3d::Zero();
  const VectorXd& mass = body.model_->mass();
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    centre += mass[i] / mass.sum() * state.x.segment<3>(3 * i);
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    if (held[static_cast<std::size_t>(i)] == 0)
      state.v.segment<3>(3 * i) = velocity + spin.cross(state.x.segment<3>(3 * i) - centre);
  if (const double limit = stable_step(scene.integrator, *body.model_, state.x); h > limit)
    return of_cloth(usage_error("a step of " + number_text(1e3 * h) + " ms is unstable with " +
                                scene.integrator + ": the limit is " + number_text(1e3 * limit) +
                                " ms"));
  auto integrator = make_nodal_integrator(scene.integrator, *body.model_, scene.options);
  if (!integrator) return of_cloth(integrator.error());
  body.integrator_ = std::move(*integrator);
  body.before_ = state.x;
  if (Status s = check_scale(scale_of(cloth, *body.model_, state, h)); !s)
    return of_cloth(s.error());
  return body;
}

BodyScale scale_of(const SceneCloth& cloth, const ClothModel& model, const NodalState& state,
                   double step) {
  const Eigen::Map<const Eigen::Matrix3Xd> x(state.x.data(), 3, state.x.size() / 3);
  const Eigen::Map<const Eigen::Matrix3Xd> v(state.v.data(), 3, state.v.size() / 3);
  return {.mass = model.mass().sum(),
          .reach = x.colwise().norm().maxCoeff(),
          .speed = v.colwise().norm().maxCoeff(),
          .gravity = model.gravity().norm(),
          .stiffness =
              std::max({cloth.structural.stiffness, cloth.shear.stiffness, cloth.bend.stiffness}),
          .step = step};
}

Status ClothBody::set_state(const VectorXd& x, const VectorXd& v) {
  if (x.size() != state_.x.size() || v.size() != state_.x.size())
    return usage_error("cloth '" + cloth().name + "' has " + std::to_string(state_.x.size()) +
                       " coordinates");
  if (!x.allFinite() || !v.allFinite()) return usage_error("a state must be finite");
  state_.x = x;
  state_.v = v;
  integrator_->reset();
  return Success{};
}

void ClothBody::stop() {
  state_.v.setZero();
  integrator_->reset();
}

bool ClothBody::is_driven() const {
  return (cloth().drag > 0.0 && !scene_.wind.isZero(0.0)) || !model_->pins_stay();
}

Status ClothBody::settle(const VectorXd& forces) {
  const Vector3d gravity = model_->gravity();
  model_->set_gravity(scene_.gravity.at(0.0));
  Result<VectorXd> x = cloth_at_rest(*model_, forces, state_.x);
  model_->set_gravity(gravity);
  if (!x) return x.error();
  before_ = *x;
  return set_state(*x, VectorXd::Zero(x->size()));
}

double ClothBody::kinetic_energy() const {
  return free_kinetic(*model_, state_.v);
}

Momenta ClothBody::momenta() const {
  Momenta sum{Vector3d::Zero(), Vector3d::Zero()};
  for (Eigen::Index i = 0; i < model_->mass().size(); ++i) {
    const Vector3d p = model_->mass()[i] * state_.v.segment<3>(3 * i);
    sum.linear += p;
    sum.angular += Vector3d(state_.x.segment<3>(3 * i)).cross(p);
  }
  return sum;
}

void ClothBody::set_gravity(const Vector3d& gravity) {
  scene_.gravity.times.clear();
  scene_.gravity.values.assign(1, gravity);
}

// The motion of released particles counts again.
void ClothBody::begin_step() {
  const double h = options().step;
  const double before = kinetic_energy();
  if (model_->release_pins(time() + kSameTime * h)) {
    work_.pins += kinetic_energy() - before;
    integrator_->reset();
  }
  model_->set_gravity(gravity_to_come());
  model_->set_wind(wind_at(scene_, time() + 0.5 * h));
  state_.time = time();
}

NodalReport ClothBody::step() {
  before_ = state_.x;
  NodalReport report = integrator_->step(state_);
  if (!report.made) return report;
  ++steps_;
  add_work(report);
  return report;
}

void ClothBody::end_step(VectorXd& x1, VectorXd& v1) {
  end_part(x1, v1);
  end_parts(1);
}

void ClothBody::end_part(VectorXd& x1, VectorXd& v1) {
  before_ = state_.x;
  state_.x.swap(x1);
  state_.v.swap(v1);
}

void ClothBody::end_parts(int parts) {
  ++steps_;
  if (parts > 1) ++cut_steps_;
  state_.time = time();
  integrator_->reset();
}

void ClothBody::carry(StateStream& stream) {
  stream(state_.x, state_.v, state_.time, work_, steps_, iterations_, cut_steps_);
  if (stream.reads())
    stream.require(state_.x.allFinite() && state_.v.allFinite() && std::isfinite(state_.time) &&
                   steps_ >= 0);
  model_->carry(stream);
  integrator_->carry(stream);
}

void ClothBody::put_back(const ClothMoment& moment) {
  state_ = moment.state;
  work_ = moment.work;
  iterations_ = moment.iterations;
}

void ClothBody::add_work(const NodalReport& report) {
  for (Eigen::Index i = 0; i < model_->mass().size(); ++i)
    work_.gravity += model_->mass()[i] *
                     model_->gravity().dot(state_.x.segment<3>(3 * i) - before_.segment<3>(3 * i));
  work_.damped += report.damped;
  work_.wind += report.driven;
  work_.pins += report.held_work;
  work_.numerical += report.numerical;
  iterations_ += report.iterations;
  if (report.parts > 1) ++cut_steps_;
}

}  // namespace tremolo
