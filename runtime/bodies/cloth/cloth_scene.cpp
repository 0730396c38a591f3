#include "runtime/bodies/cloth/cloth_scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/overflow.h"
#include "common/text.h"

namespace tremolo {
namespace {

bool is_positive(double value) {
  return value > 0.0 && std::isfinite(value);
}
bool is_not_negative(double value) {
  return value >= 0.0 && std::isfinite(value);
}

Error about(const std::string& what, const Error& error) {
  return {error.kind, what + ": " + error.message};
}

Status check_law(const char* kind, const SpringLaw& law) {
  if (!is_not_negative(law.stiffness))
    return content_error(std::string(kind) + ": stiffness is " + number_text(law.stiffness) +
                         ", must be finite and not negative (N/m)");
  if (!is_not_negative(law.damping))
    return content_error(std::string(kind) + ": damping is " + number_text(law.damping) +
                         ", must be finite and not negative (N s/m)");
  if (Status s = check_size(std::string(kind) + ": stiffness", law.stiffness, "N/m"); !s) return s;
  return check_size(std::string(kind) + ": damping", law.damping, "N s/m");
}

Status check_grid(const ClothGrid& grid) {
  if (grid.columns < 2 || grid.rows < 2)
    return content_error("columns and rows must be at least 2");
  if (grid.columns > 10000 || grid.rows > 10000)
    return content_error("columns and rows must be at most 10000");
  if (!is_positive(grid.width) || !is_positive(grid.height))
    return content_error("width and height must be positive and finite (m)");
  if (!grid.corner.allFinite()) return content_error("corner is not finite");
  for (const auto& [name, value] : {std::pair{"width", grid.width},
                                    {"height", grid.height},
                                    {"corner", grid.corner.lpNorm<Eigen::Infinity>()}})
    if (Status s = check_size(name, value, "m"); !s) return s;
  for (const Eigen::Vector3d& way : {grid.along, grid.across})
    if (!(std::abs(way.norm() - 1.0) <= 1e-6))
      return content_error("along and across must be of length 1");
  if (!(std::abs(grid.along.dot(grid.across)) <= 1e-6))
    return content_error("along and across must be at right angles");
  return Success{};
}

Status check_cloth_motion(const Motion& motion) {
  const Result<MotionPath> path = MotionPath::create(motion);
  if (!path) return path.error();
  if (path->refused_jump() < kForEver)
    return content_error("its motion jumps at t = " + number_text(path->refused_jump()) +
                         " s: say jumps = \"smooth\" to spread it over smooth-time");
  return Success{};
}

Status check_pin(const ClothPin& pin, std::size_t particles) {
  if (pin.particles.empty()) return content_error("its list of particles is empty");
  for (const std::size_t particle : pin.particles)
    if (particles > 0 && particle >= particles)
      return content_error("there is no particle " + std::to_string(particle) + ", only " +
                           std::to_string(particles));
  if (!(pin.until > 0.0)) return content_error("until must be positive (s)");
  return check_cloth_motion(pin.motion);
}

Status check_touch(double friction, double restitution) {
  if (!is_not_negative(friction)) return content_error("friction must be finite and not negative");
  if (!(restitution >= 0.0 && restitution <= 1.0))
    return content_error("restitution must be from 0 to 1");
  return Success{};
}

Status check_cloth(const SceneCloth& cloth) {
  const bool grid = cloth.grid.columns > 0 || cloth.grid.rows > 0;
  if (grid == !cloth.file.empty()) return content_error("it needs a grid or a file, one of both");
  if (grid)
    if (Status s = check_grid(cloth.grid); !s) return s;
  if (const std::string problem = pose_problem({cloth.position, cloth.rotation}); !problem.empty())
    return content_error(problem);
  if (!is_positive(cloth.density))
    return content_error("density is " + number_text(cloth.density) +
                         ", must be positive and finite (kg/m^2)");
  if (Status s = check_size("position", cloth.position.lpNorm<Eigen::Infinity>(), "m"); !s)
    return s;
  if (Status s = check_size("density", cloth.density, "kg/m^2"); !s) return s;
  if (Status s = check_size("drag", cloth.drag, "kg/m^3"); !s) return s;
  if (Status s = check_size("thickness", cloth.thickness, "m"); !s) return s;
  if (Status s = check_law("structural", cloth.structural); !s) return s;
  if (Status s = check_law("shear", cloth.shear); !s) return s;
  if (Status s = check_law("bend", cloth.bend); !s) return s;
  if (!is_not_negative(cloth.drag))
    return content_error("drag must be finite and not negative (kg/m^3)");
  if (!is_not_negative(cloth.thickness))
    return content_error("thickness must be finite and not negative (m)");
  if (!(cloth.crumple >= 0.0 && cloth.crumple <= 0.5))
    return content_error("crumple must be from 0 to 0.5");
  if (Status s = check_touch(cloth.friction, cloth.restitution); !s) return s;
  for (std::size_t i = 0; i < cloth.pins.size(); ++i)
    if (Status s = check_pin(cloth.pins[i], cloth.grid.columns * cloth.grid.rows); !s)
      return about("pin " + std::to_string(i + 1), s.error());
  return Success{};
}

Status check_ball(const SceneBall& ball) {
  if (!is_positive(ball.radius)) return content_error("radius must be positive and finite (m)");
  if (!is_positive(ball.mass)) return content_error("mass must be positive and finite (kg)");
  if (!ball.position.allFinite() || !ball.velocity.allFinite() || !ball.spin.allFinite())
    return content_error("position, velocity or spin is not finite");
  if (Status s = check_size("radius", ball.radius, "m"); !s) return s;
  if (Status s = check_size("mass", ball.mass, "kg"); !s) return s;
  if (Status s = check_start_size(ball.position, ball.velocity, ball.spin); !s) return s;
  if (Status s = check_scale({.mass = ball.mass,
                              .reach = ball.position.norm() + ball.radius,
                              .speed = ball.velocity.norm() + ball.radius * ball.spin.norm()});
      !s)
    return s;
  if (!ball.fixed && !ball.motion.parts.empty())
    return content_error("a motion moves a fixed ball only");
  if (Status s = check_touch(ball.friction, ball.restitution); !s) return s;
  return check_cloth_motion(ball.motion);
}

Status check_collider(const SceneCollider& collider) {
  if (collider.file.empty())
    if (Status s = check(collider.shape); !s) return s;
  if (const std::string problem = pose_problem(collider.pose); !problem.empty())
    return content_error(problem);
  if (Status s = check_size("position", collider.pose.position.lpNorm<Eigen::Infinity>(), "m"); !s)
    return s;
  if (Status s = check_touch(collider.friction, collider.restitution); !s) return s;
  return check_cloth_motion(collider.motion);
}

Status check_hand(const ClothScene& scene, const ClothHand& hand) {
  const auto named = [&hand](const SceneCloth& cloth) { return cloth.name == hand.cloth; };
  const auto cloth = std::find_if(scene.cloths.begin(), scene.cloths.end(), named);
  if (cloth == scene.cloths.end()) return content_error("there is no cloth '" + hand.cloth + "'");
  const std::size_t particles = cloth->grid.columns * cloth->grid.rows;
  if (particles > 0 && hand.particle >= particles)
    return content_error("there is no particle " + std::to_string(hand.particle) + " of cloth '" +
                         hand.cloth + "', only " + std::to_string(particles));
  if (!(hand.from >= 0.0) || !(hand.until > hand.from))
    return content_error("until must be later than from, and from not negative (s)");
  return check_cloth_motion(hand.motion);
}

// Checks that the names are unique.
template <class Thing, class Check>
Status check_named(const std::vector<Thing>& things, const std::string& kind, const Check& good) {
  std::set<std::string> names;
  for (const Thing& thing : things) {
    if (thing.name.empty()) return content_error("a " + kind + " has no name");
    if (!names.insert(thing.name).second)
      return content_error("two " + kind + "s are named '" + thing.name + "'");
    if (Status s = good(thing); !s) return about(kind + " '" + thing.name + "'", s.error());
  }
  return Success{};
}

Status check_weather(const ClothScene& scene) {
  const SceneGravity& gravity = scene.gravity;
  if (gravity.values.size() > 1 && gravity.times.size() != gravity.values.size())
    return content_error("gravity: each value needs a time");
  for (const Eigen::Vector3d& value : gravity.values) {
    if (!value.allFinite()) return content_error("gravity is not finite");
    if (Status s = check_size("gravity", value.lpNorm<Eigen::Infinity>(), "m/s^2"); !s) return s;
  }
  for (std::size_t k = 1; k < gravity.times.size(); ++k)
    if (!(gravity.times[k - 1] < gravity.times[k]))
      return content_error("gravity: the times must ascend");
  if (!scene.wind.allFinite()) return content_error("wind is not finite");
  if (Status s = check_size("wind", scene.wind.lpNorm<Eigen::Infinity>(), "m/s"); !s) return s;
  if (Status s = check_size("gust", scene.gust, ""); !s) return s;
  if (Status s = check_size("gust-hz", scene.gust_hz, "Hz"); !s) return s;
  if (!is_not_negative(scene.gust) || !is_not_negative(scene.gust_hz))
    return content_error("gust and gust-hz must be finite and not negative");
  return Success{};
}

}  // namespace

Status check_scene(const ClothScene& scene) {
  if (!is_positive(scene.options.step))
    return content_error("step must be positive and finite (s)");
  if (Status s = check_step_size(scene.options.step); !s) return s;
  if (!is_positive(scene.duration))
    return content_error("duration must be positive and finite (s)");
  const auto names = nodal_integrator_names();
  if (std::find(names.begin(), names.end(), scene.integrator) == names.end())
    return content_error("integrator: there is no '" + scene.integrator + "'");
  if (scene.cloths.empty()) return content_error("the scene has no cloth");
  if (Status s = check_weather(scene); !s) return s;
  if (Status s = check_named(scene.cloths, "cloth", check_cloth); !s) return s;
  if (Status s = check_named(scene.balls, "ball", check_ball); !s) return s;
  if (Status s = check_named(scene.colliders, "collider", check_collider); !s) return s;
  for (std::size_t i = 0; i < scene.hands.size(); ++i)
    if (Status s = check_hand(scene, scene.hands[i]); !s)
      return about("hand " + std::to_string(i + 1), s.error());
  return Success{};
}

}  // namespace tremolo
