// ClothWorld::create: makes a scene's cloths, balls and colliders, and checks the scene.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "common/text.h"
#include "runtime/bodies/cloth/cloth_body.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_world_inside.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Error of_cloth(const SceneCloth& cloth, const Error& error) {
  return {error.kind, "cloth '" + cloth.name + "': " + error.message};
}

// Milliseconds with three digits, rounded down: a step of this length is allowed.
std::string milliseconds_text(double seconds) {
  const double ms = 1e3 * seconds;
  if (!(ms > 0.0)) return "0 ms";
  const double unit = std::pow(10.0, std::floor(std::log10(ms)) - 2.0);
  return number_text(std::floor(ms / unit) * unit) + " ms";
}

Result<SceneColliders> make_colliders(const ClothScene& scene) {
  Scene place;
  place.step = scene.options.step;
  place.colliders = scene.colliders;
  return SceneColliders::create(place);
}

}  // namespace

Status ClothWorld::Inside::add_cloth(const SceneCloth& wanted) {
  Result<ClothModel> model = make_cloth_model(wanted);
  if (!model) return of_cloth(wanted, model.error());
  auto cloth = std::make_unique<WorldCloth>(
      WorldCloth{wanted, std::move(*model), {}, {}, nullptr, nullptr, false});
  const auto held = cloth->model.held();
  cloth->state.x = crumpled(cloth->model.parts(), wanted.crumple, {held.begin(), held.end()});
  cloth->model.put_held(0.0, cloth->state.x);
  cloth->state.v = Eigen::VectorXd::Zero(cloth->state.x.size());
  if (wanted.settled) {
    cloth->model.set_gravity(scene.gravity.at(0.0));
    if (Status s =
            take(cloth->state.x, cloth_at_rest(cloth->model, cloth->state.v, cloth->state.x));
        !s)
      return of_cloth(wanted, s.error());
  }
  if (Status s = check_scale(scale_of(wanted, cloth->model, cloth->state, scene.options.step)); !s)
    return of_cloth(wanted, s.error());
  cloth->before = cloth->state;
  cloth->model.set_gravity(gravity);
  limit = std::min(limit, stable_step(scene.integrator, cloth->model, cloth->state.x));
  if (Status s = check_limit(); !s) return of_cloth(wanted, s.error());
  auto integrator = make_nodal_integrator(scene.integrator, cloth->model, scene.options);
  if (!integrator) return of_cloth(wanted, integrator.error());
  cloth->integrator = std::move(*integrator);
  touching.push_back({.model = &cloth->model,
                      .state = &cloth->state,
                      .thickness = wanted.thickness,
                      .friction = wanted.friction,
                      .restitution = wanted.restitution,
                      .touched = false,
                      .grounded = std::vector<std::uint8_t>(held.size(), 0)});
  cloths.push_back(std::move(cloth));
  return Success{};
}

// Only if there is an obstacle.
void ClothWorld::Inside::make_reactions() {
  around.balls = balls;
  around.ways.resize(balls.size());
  const bool any = solves_steps() && !(balls.empty() && scene.colliders.empty());
  for (const auto& cloth : cloths) {
    if (any == (cloth->reactions != nullptr)) continue;
    cloth->model.set_contact(nullptr);
    cloth->reactions.reset();
    if (!any) continue;
    cloth->reactions = std::make_unique<ClothReactions>(
        cloth->model, around, cloth->scene.thickness, cloth->scene.friction);
    cloth->model.set_contact(cloth->reactions.get());
  }
}

namespace {

Status check_stable(std::string_view integrator, double step, double limit) {
  if (step <= limit * (1.0 + 1e-9)) return Success{};
  return usage_error("a step of " + number_text(1e3 * step) + " ms is unstable with " +
                     std::string(integrator) + ": the limit is " + milliseconds_text(limit) +
                     (limit > 0.0 ? "" : " without dampers"));
}

}  // namespace

Status ClothWorld::Inside::check_limit() const {
  return check_stable(scene.integrator, scene.options.step, limit);
}

Result<double> ClothWorld::stability_limit_of(std::string_view integrator, double step) const {
  if (!(step > 0.0) || !std::isfinite(step))
    return usage_error("a step must be positive and finite, got " + number_text(step) + " s");
  const auto names = nodal_integrator_names();
  if (std::find(names.begin(), names.end(), integrator) == names.end())
    return usage_error("there is no method '" + std::string(integrator) + "'");
  double limit = std::numeric_limits<double>::infinity();
  for (const auto& cloth : inside_->cloths) {
    for (const Eigen::VectorXd* x :
         std::initializer_list<const Eigen::VectorXd*>{&cloth->model.parts().x, &cloth->state.x})
      limit = std::min(limit, stable_step(integrator, cloth->model, *x));
    if (Status s = check_stable(integrator, step, limit); !s)
      return of_cloth(cloth->scene, s.error());
  }
  return limit;
}

Status ClothWorld::set_method(std::string_view integrator, double step) {
  const Result<double> limit = stability_limit_of(integrator, step);
  if (!limit) return limit.error();
  Inside& in = *inside_;
  NodalOptions options = in.scene.options;
  options.step = step;
  std::vector<std::unique_ptr<NodalIntegrator>> made;
  for (const auto& cloth : in.cloths) {
    auto one = make_nodal_integrator(integrator, cloth->model, options);
    if (!one) return of_cloth(cloth->scene, one.error());
    made.push_back(std::move(*one));
  }
  for (std::size_t i = 0; i < made.size(); ++i) in.cloths[i]->integrator = std::move(made[i]);
  in.steps = std::llround(time() / step);
  in.scene.integrator = integrator;
  in.scene.options = options;
  in.limit = *limit;
  in.make_reactions();
  return Success{};
}

Result<ClothWorld> ClothWorld::create(const ClothScene& scene) {
  if (Status s = check_scene(scene); !s) return s.error();
  auto inside = std::make_unique<Inside>();
  inside->scene = scene;
  inside->limit = std::numeric_limits<double>::infinity();
  inside->gravity = scene.gravity.at(0.5 * scene.options.step);
  for (const SceneCloth& cloth : scene.cloths)
    if (Status s = inside->add_cloth(cloth); !s) return s.error();
  for (const SceneBall& wanted : scene.balls) {
    Result<MovingBall> ball = make_ball(wanted);
    if (!ball)
      return Error{ball.error().kind, "ball '" + wanted.name + "': " + ball.error().message};
    inside->balls.push_back(std::move(*ball));
    inside->shown.push_back(inside->balls.back().now);
  }
  if (Status s = take(inside->colliders, make_colliders(scene)); !s) return s.error();
  if (Status s = inside->check_apart(); !s) return s.error();
  inside->make_reactions();
  for (const ClothHand& hand : scene.hands)
    if (Status s = inside->add_hand(hand); !s) return s.error();
  return ClothWorld(std::move(inside));
}

}  // namespace tremolo
