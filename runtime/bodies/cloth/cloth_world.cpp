#include "runtime/bodies/cloth/cloth_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "common/text.h"
#include "runtime/bodies/cloth/cloth_body.h"
#include "runtime/bodies/cloth/cloth_world_inside.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Sum of m x over a cloth, kg m.
Vector3d first_moment(const WorldCloth& cloth) {
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < cloth.model.mass().size(); ++i)
    sum += cloth.model.mass()[i] * cloth.state.x.segment<3>(3 * i);
  return sum;
}

double ball_kinetic(const MovingBall& ball) {
  if (ball.inverse_mass == 0.0) return 0.0;
  return 0.5 * (ball.now.velocity.squaredNorm() / ball.inverse_mass +
                ball.now.spin.squaredNorm() / ball.inverse_inertia);
}

}  // namespace

double free_cloth_kinetic(const WorldCloth& cloth) {
  const auto held = cloth.model.held();
  double twice = 0.0;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i] == 0)
      twice += cloth.model.mass()[i] * cloth.state.v.segment<3>(3 * i).squaredNorm();
  return 0.5 * twice;
}

ClothWorld::ClothWorld(std::unique_ptr<Inside> inside) : inside_(std::move(inside)) {}
ClothWorld::ClothWorld(ClothWorld&&) noexcept = default;
ClothWorld& ClothWorld::operator=(ClothWorld&&) noexcept = default;
ClothWorld::~ClothWorld() = default;

void ClothWorld::Inside::add_present(ClothEnergy& energy) const {
  energy.kinetic = energy.elastic = energy.gravity = 0.0;
  for (const auto& cloth : cloths) {
    energy.kinetic += free_cloth_kinetic(*cloth);
    energy.elastic += cloth->model.elastic_energy(cloth->state.x);
    energy.gravity -= gravity.dot(first_moment(*cloth));
  }
  for (const MovingBall& ball : balls) {
    energy.kinetic += ball_kinetic(ball);
    if (ball.inverse_mass > 0.0)
      energy.gravity -= gravity.dot(ball.now.position) / ball.inverse_mass;
  }
}

// A change of gravity changes the potential energy of everything; it is added to the wind's work.
void ClothWorld::Inside::set_weather(double t) {
  const Vector3d now = scene.gravity.at(t), change = now - gravity;
  if (!change.isZero(0.0)) {
    for (const auto& cloth : cloths) sums.wind -= change.dot(first_moment(*cloth));
    for (const MovingBall& ball : balls)
      if (ball.inverse_mass > 0.0) sums.wind -= change.dot(ball.now.position) / ball.inverse_mass;
  }
  gravity = now;
  for (const auto& cloth : cloths) {
    cloth->model.set_gravity(now);
    cloth->model.set_wind(wind_at(scene, t));
  }
}

// The motion of released particles counts again, that of newly fixed ones no longer.
void ClothWorld::Inside::release_pins(double t) {
  for (const auto& cloth : cloths) {
    const double before = free_cloth_kinetic(*cloth);
    if (!cloth->model.release_pins(t)) continue;
    sums.pins += free_cloth_kinetic(*cloth) - before;
    cloth->integrator->reset();
  }
}

Status ClothWorld::Inside::advance_cloths(double t) {
  ClothEnergy made = sums;
  for (const auto& cloth : cloths) cloth->before = cloth->state;
  for (const auto& cloth : cloths) {
    cloth->state.time = t;
    cloth->model.begin_holds(t, scene.options.step, cloth->state.x);
    const NodalReport report = cloth->integrator->step(cloth->state);
    if (!report.made) {
      for (const auto& other : cloths) {
        other->state = other->before;
        other->integrator->reset();
      }
      return Error{ErrorKind::kSolver, "cloth '" + cloth->scene.name +
                                           "': the step at t = " + number_text(t) +
                                           " s could not be made, nor parts of it"};
    }
    made.contact += report.pressed;
    made.damped += report.damped;
    made.wind += report.driven;
    made.pins += report.held_work;
    made.numerical += report.numerical;
    iterations += report.iterations;
    if (report.parts > 1) ++cut_steps;
  }
  sums = made;
  return Success{};
}

// True if any particle was moved.
bool ClothWorld::Inside::project(double h) {
  if (balls.empty() && scene.colliders.empty()) return false;
  const double time = solves_steps() ? 0.0 : friction_time(scene.integrator, h);
  for (ContactCloth& cloth : touching) cloth.friction_time = time;
  const ContactReport report = contact.project(touching, balls, colliders.placed(), gravity, h);
  penetration = std::max(penetration, report.penetration);
  if (!report.touched) return false;
  for (std::size_t i = 0; i < cloths.size(); ++i)
    cloths[i]->touched = cloths[i]->touched || touching[i].touched;
  return true;
}

double ClothWorld::Inside::present() const {
  ClothEnergy energy;
  add_present(energy);
  return energy.total();
}

// Energy from outside since the start, J.
double ClothWorld::Inside::given() const {
  return sums.wind + sums.pins - sums.damped;
}

// After the cloths' own steps: moves balls and applies all contact at once. True if there was any.
bool ClothWorld::Inside::touch(double t, double h) {
  if (balls.empty() && scene.colliders.empty()) return false;
  for (const auto& cloth : cloths) cloth->touched = false;
  ClothEnergy before, after;
  add_present(before);
  const bool solves = solves_steps();
  if (solves) push_balls(h);
  for (MovingBall& ball : balls) move_ball(gravity, t, h, ball);
  const bool pressed = solves && settle_all(h);
  const bool moved = project(h);
  if (!moved && !pressed) return false;
  for (const auto& cloth : cloths)
    if (cloth->touched) cloth->integrator->reset();
  add_present(after);
  sums.contact += after.total() - before.total();
  return true;
}

Status ClothWorld::step() {
  Inside& in = *inside_;
  const double h = in.scene.options.step, t = time();
  in.release_pins(t + kSameTime * h);
  in.move_hands();
  in.set_weather(t + 0.5 * h);
  in.colliders.move(in.steps, h);
  const bool presses = in.cloths.front()->reactions != nullptr;
  const double before = presses ? in.present() - in.given() : 0.0;
  if (presses) in.begin_contact(t, h);
  if (Status s = in.advance_cloths(t); !s) return s;
  if (in.touch(t, h) && presses && in.stands_still()) {
    const double excess = in.present() - in.given() - before;
    if (excess > 0.0) in.sums.contact -= in.take_excess(excess);
  }
  ++in.steps;
  for (std::size_t i = 0; i < in.balls.size(); ++i) in.shown[i] = in.balls[i].now;
  return Success{};
}

const ClothScene& ClothWorld::scene() const {
  return inside_->scene;
}
double ClothWorld::time() const {
  return static_cast<double>(inside_->steps) * inside_->scene.options.step;
}
std::int64_t ClothWorld::steps() const {
  return inside_->steps;
}
std::size_t ClothWorld::cloths() const {
  return inside_->cloths.size();
}
std::size_t ClothWorld::particles(std::size_t cloth) const {
  return inside_->cloths[cloth]->model.size();
}
const Eigen::VectorXd& ClothWorld::positions(std::size_t cloth) const {
  return inside_->cloths[cloth]->state.x;
}
const Eigen::VectorXd& ClothWorld::velocities(std::size_t cloth) const {
  return inside_->cloths[cloth]->state.v;
}
const std::vector<Triangle>& ClothWorld::triangles(std::size_t cloth) const {
  return inside_->cloths[cloth]->model.parts().triangles;
}
const ClothModel& ClothWorld::model(std::size_t cloth) const {
  return inside_->cloths[cloth]->model;
}

Status ClothWorld::set_state(std::size_t cloth, const Eigen::VectorXd& x,
                             const Eigen::VectorXd& v) {
  if (cloth >= cloths()) return usage_error("there is no cloth " + std::to_string(cloth));
  WorldCloth& of = *inside_->cloths[cloth];
  if (x.size() != of.state.x.size() || v.size() != of.state.x.size())
    return usage_error("cloth '" + of.scene.name + "' has " + std::to_string(of.state.x.size()) +
                       " coordinates");
  if (!x.allFinite() || !v.allFinite()) return usage_error("a state must be finite");
  of.state.x = x;
  of.state.v = v;
  of.integrator->reset();
  return Success{};
}

std::span<const ClothWorld::Ball> ClothWorld::balls() const {
  return inside_->shown;
}
Pose ClothWorld::collider_pose(std::size_t collider) const {
  const PlacedCollider& placed = inside_->colliders.placed()[collider];
  return inside_->steps == 0 ? placed.start : placed.end;
}

ClothEnergy ClothWorld::energy() const {
  ClothEnergy energy = inside_->sums;
  inside_->add_present(energy);
  return energy;
}

Vector3d ClothWorld::linear_momentum() const {
  Vector3d sum = Vector3d::Zero();
  for (const auto& cloth : inside_->cloths) {
    const auto held = cloth->model.held();
    for (std::size_t i = 0; i < held.size(); ++i)
      if (held[i] == 0) sum += cloth->model.mass()[i] * cloth->state.v.segment<3>(3 * i);
  }
  for (const MovingBall& ball : inside_->balls)
    if (ball.inverse_mass > 0.0) sum += ball.now.velocity / ball.inverse_mass;
  return sum;
}

Vector3d ClothWorld::angular_momentum() const {
  Vector3d sum = Vector3d::Zero();
  for (const auto& cloth : inside_->cloths) {
    const auto held = cloth->model.held();
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (held[i] != 0) continue;
      const Vector3d x = cloth->state.x.segment<3>(3 * i);
      sum += cloth->model.mass()[i] * x.cross(cloth->state.v.segment<3>(3 * i));
    }
  }
  for (const MovingBall& ball : inside_->balls)
    if (ball.inverse_mass > 0.0)
      sum += ball.now.position.cross(ball.now.velocity) / ball.inverse_mass +
             ball.now.spin / ball.inverse_inertia;
  return sum;
}

double ClothWorld::stability_limit() const {
  return inside_->limit;
}
double ClothWorld::penetration_max() const {
  return inside_->penetration;
}
std::int64_t ClothWorld::iterations() const {
  return inside_->iterations;
}
std::int64_t ClothWorld::cut_steps() const {
  return inside_->cut_steps;
}

}  // namespace tremolo
