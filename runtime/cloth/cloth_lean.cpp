// What touched something in the last step, or would be in it if it went on, leans on it in this
// one, inside the solve (ClothLean): tension then presses instead of pulling particles through, and
// what was leaned on feels the whole reaction. Methods that solve nothing take contact by
// projection alone.
#include <algorithm>
#include <cmath>
#include <optional>

#include "runtime/cloth/cloth_world_inside.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// The spring of a lean over what the particle resists with in a step, so that it gives way by some
// percent of what it would without.
constexpr double kLeanShare = 50.0;

bool solves_steps(std::string_view method) {
  return std::isinf(stability_number(method)) || method == "imex";
}

// Whether the method's forces are those of the mean of a step's ends, or of its end.
bool acts_in_middle(std::string_view method) {
  return method == "midpoint" || method == "energy" || method == "imex";
}

Vector3d ball_velocity_at(const MovingBall& ball, const Vector3d& x) {
  return ball.now.velocity + ball.now.spin.cross(x - ball.now.position);
}

// Only what acts at the end of a step alone, and damps what is stiff, may lean on what it has not
// touched yet: other methods swing about the place and gain energy.
bool looks_ahead(std::string_view method) {
  return method.starts_with("implicit-euler");
}

double stiffness_of(const WorldCloth& cloth, Eigen::Index particle, double h) {
  return kLeanShare *
         (cloth.model.mass()[particle] / (h * h) + 8.0 * cloth.scene.structural.stiffness);
}

}  // namespace

// Where the particle would be put if it went on as it goes, in the first ball or collider that it
// would then be in; its touch is that one from now on.
std::optional<Vector3d> ClothWorld::Inside::will_touch(const WorldCloth& cloth, Eigen::Index at,
                                                       double h, ParticleTouch& touch) const {
  const Vector3d x = cloth.state.x.segment<3>(3 * at);
  const Vector3d goes = x + h * (cloth.state.v.segment<3>(3 * at) + h * gravity);
  const double thickness = cloth.scene.thickness;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const Vector3d centre = balls[b].now.position + h * balls[b].now.velocity;
    const double reach = balls[b].radius + thickness, distance = (goes - centre).norm();
    if (!(distance < reach) || distance == 0.0) continue;
    touch = {.normal = (goes - centre) / distance, .ball = b};
    return centre + reach * touch.normal;
  }
  for (std::size_t k = 0; k < colliders.placed().size(); ++k) {
    const CollisionDistance found = distance_at_end(colliders.placed()[k], goes);
    if (!(found.distance < thickness) || found.normal.squaredNorm() < 1e-4) continue;
    touch = {.normal = found.normal.normalized(), .collider = k};
    return goes + (thickness - found.distance) * touch.normal;
  }
  return std::nullopt;
}

void ClothWorld::Inside::lean(double h) {
  if (!solves_steps(scene.integrator)) return;
  for (std::size_t c = 0; c < cloths.size(); ++c) {
    WorldCloth& cloth = *cloths[c];
    std::vector<ClothLean>& leans = cloth.model.leans();
    leans.clear();
    for (std::size_t i = 0; i < cloth.model.size(); ++i) {
      if (cloth.model.held()[i] != 0) continue;
      const auto at = static_cast<Eigen::Index>(i);
      const Vector3d x = cloth.state.x.segment<3>(3 * at);
      ParticleTouch& touch = touching[c].touches[i];
      if (!touch.any()) {
        if (!looks_ahead(scene.integrator)) continue;
        if (const auto place = will_touch(cloth, at, h, touch))
          leans.push_back({i, touch.normal, *place, stiffness_of(cloth, at, h)});
        continue;
      }
      const Vector3d surface = touch.ball != ParticleTouch::kNone
                                   ? ball_velocity_at(balls[touch.ball], x)
                                   : surface_velocity(colliders.placed()[touch.collider], x, h);
      leans.push_back({i, touch.normal, x + h * surface, stiffness_of(cloth, at, h)});
    }
  }
}

// The reaction of one lean, N: friction on the particle, and all of it on a ball.
void ClothWorld::Inside::push_back_from(std::size_t c, const ClothLean& lean, double reaction,
                                        double h) {
  WorldCloth& cloth = *cloths[c];
  const ParticleTouch& touch = touching[c].touches[lean.particle];
  const auto at = static_cast<Eigen::Index>(lean.particle);
  MovingBall* ball = touch.ball != ParticleTouch::kNone ? &balls[touch.ball] : nullptr;
  const Vector3d x = cloth.state.x.segment<3>(3 * at);
  const Vector3d surface = ball != nullptr
                               ? ball_velocity_at(*ball, x)
                               : surface_velocity(colliders.placed()[touch.collider], x, h);
  const Vector3d relative = cloth.state.v.segment<3>(3 * at) - surface;
  const Vector3d slides = relative - lean.normal.dot(relative) * lean.normal;
  const double other = ball != nullptr ? ball->friction : scene.colliders[touch.collider].friction;
  const double mass = cloth.model.mass()[at], speed = slides.norm();
  const double most = std::sqrt(cloth.scene.friction * other) * std::max(reaction, 0.0) * h;
  Vector3d rubs = Vector3d::Zero();  // N s
  if (speed > 0.0) rubs = -std::min(mass * speed, most) / speed * slides;
  cloth.state.v.segment<3>(3 * at) += rubs / mass;
  if (ball == nullptr || ball->inverse_mass == 0.0) return;
  const Vector3d impulse = -(reaction * h * lean.normal + rubs);
  ball->now.velocity += ball->inverse_mass * impulse;
  ball->now.spin += ball->inverse_inertia * (x - ball->now.position).cross(impulse);
}

void ClothWorld::Inside::push_back(double h) {
  ClothEnergy before, after;
  add_present(before);
  const bool middle = acts_in_middle(scene.integrator);
  bool any = false;
  for (std::size_t c = 0; c < cloths.size(); ++c)
    for (const ClothLean& lean : cloths[c]->model.leans()) {
      any = true;
      const double end = lean.gap(cloths[c]->state.x);
      const double gap = middle ? 0.5 * (lean.gap(cloths[c]->before.x) + end) : end;
      push_back_from(c, lean, -lean.stiffness * gap, h);
    }
  if (!any) return;
  add_present(after);
  told.contact += after.total() - before.total();
}

}  // namespace tremolo
