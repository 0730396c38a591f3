// runtime/tremolo_cloth.h: cloth from C.
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/c/c_api.h"
#include "runtime/c/nodal_c_api.h"
#include "runtime/tremolo_cloth.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_cloth_scene {
  tremolo::ClothScene scene;
};
struct tremolo_cloth_world {
  tremolo::ClothWorld world;
};
// NOLINTEND(readability-identifier-naming)

namespace {

using Eigen::Vector3d;
using tremolo::ClothWorld;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::fill_buffer;
using tremolo::c_api::need;
using tremolo::c_api::put;
using tremolo::c_api::with_all;

Status need_cloth(const ClothWorld& world, size_t cloth) {
  if (cloth < world.cloths()) return Success{};
  return usage_error("there are " + std::to_string(world.cloths()) + " cloths, no cloth " +
                     std::to_string(cloth));
}

// Copies the cloth's `values`, 3 per particle.
template <class Values>
tremolo_status copy_vectors(const tremolo_cloth_world* world, size_t cloth, double* out,
                            size_t length, const Values& values) noexcept {
  return with_all({{world, "the world of cloth"}}, [&]() -> Status {
    if (Status s = need_cloth(world->world, cloth); !s) return s;
    return fill_buffer(values(world->world), out, length);
  });
}

}  // namespace

tremolo::SceneCloth tremolo::c_api::to_cloth(const tremolo_cloth_options& options,
                                             std::string name) {
  SceneCloth cloth;
  cloth.name = std::move(name);
  if (options.file != nullptr) {
    cloth.file = options.file;
    cloth.position = Vector3d(options.corner);
  } else {
    cloth.grid = {options.columns,
                  options.rows,
                  options.width,
                  options.height,
                  Vector3d(options.corner),
                  Vector3d(options.along),
                  Vector3d(options.across)};
  }
  cloth.density = options.density;
  cloth.structural = {options.stiffness[0], options.damping[0]};
  cloth.shear = {options.stiffness[1], options.damping[1]};
  cloth.bend = {options.stiffness[2], options.damping[2]};
  cloth.drag = options.drag;
  cloth.thickness = options.thickness;
  cloth.friction = options.friction;
  cloth.restitution = options.restitution;
  return cloth;
}

tremolo_status tremolo_cloth_scene_create(const char* method, double step,
                                          tremolo_cloth_scene** scene) {
  return with_all({{scene, "the place for the scene"}}, [&]() -> Status {
    auto made = std::make_unique<tremolo_cloth_scene>();
    if (method != nullptr) made->scene.integrator = method;
    made->scene.options.step = step;
    made->scene.gravity.times = {0.0};
    made->scene.gravity.values = {Vector3d(0.0, 0.0, -9.81)};
    *scene = made.release();
    return Success{};
  });
}

void tremolo_cloth_scene_destroy(tremolo_cloth_scene* scene) {
  delete scene;
}

tremolo_status tremolo_cloth_scene_set_gravity(tremolo_cloth_scene* scene,
                                               const double gravity[3]) {
  return with_all({{scene, "the scene"}, {gravity, "gravity"}}, [&]() -> Status {
    scene->scene.gravity.values = {Vector3d(gravity)};
    return Success{};
  });
}

tremolo_status tremolo_cloth_scene_set_wind(tremolo_cloth_scene* scene, const double wind[3]) {
  return with_all({{scene, "the scene"}, {wind, "the wind"}}, [&]() -> Status {
    scene->scene.wind = Vector3d(wind);
    return Success{};
  });
}

void tremolo_cloth_options_init(tremolo_cloth_options* options) {
  if (options == nullptr) return;
  const tremolo::SceneCloth usual;
  *options = {
      .size = sizeof(tremolo_cloth_options),
      .columns = 20,
      .rows = 20,
      .reserved = 0,
      .file = nullptr,
      .width = 1.0,
      .height = 1.0,
      .corner = {0.0, 0.0, 0.0},
      .along = {1.0, 0.0, 0.0},
      .across = {0.0, 1.0, 0.0},
      .density = usual.density,
      .stiffness = {usual.structural.stiffness, usual.shear.stiffness, usual.bend.stiffness},
      .damping = {usual.structural.damping, usual.shear.damping, usual.bend.damping},
      .drag = usual.drag,
      .thickness = usual.thickness,
      .friction = usual.friction,
      .restitution = usual.restitution};
}

tremolo_status tremolo_cloth_scene_add(tremolo_cloth_scene* scene,
                                       const tremolo_cloth_options* options, size_t* cloth) {
  return with_all({{scene, "the scene"}}, [&]() -> Status {
    const auto full =
        tremolo::c_api::complete(options, tremolo_cloth_options_init, "tremolo_cloth_options_init");
    if (!full) return full.error();
    const size_t number = scene->scene.cloths.size();
    scene->scene.cloths.push_back(
        tremolo::c_api::to_cloth(*full, "cloth " + std::to_string(number)));
    put(number, cloth);
    return Success{};
  });
}

tremolo_status tremolo_cloth_scene_pin(tremolo_cloth_scene* scene, size_t cloth,
                                       const size_t* particles, size_t count) {
  return with_all({{scene, "the scene"}, {particles, "the particles"}}, [&]() -> Status {
    if (cloth >= scene->scene.cloths.size())
      return usage_error("there is no cloth " + std::to_string(cloth));
    tremolo::ClothPin pin;
    pin.particles.assign(particles, particles + count);
    scene->scene.cloths[cloth].pins.push_back(std::move(pin));
    return Success{};
  });
}

tremolo_status tremolo_cloth_scene_add_ball(tremolo_cloth_scene* scene, double radius, double mass,
                                            const double position[3], const double velocity[3]) {
  return with_all({{scene, "the scene"}, {position, "the position"}, {velocity, "the velocity"}},
                  [&]() -> Status {
                    tremolo::SceneBall ball;
                    ball.name = "ball " + std::to_string(scene->scene.balls.size());
                    ball.radius = radius;
                    ball.fixed = mass == 0.0;
                    if (!ball.fixed) ball.mass = mass;
                    ball.position = Vector3d(position);
                    ball.velocity = Vector3d(velocity);
                    scene->scene.balls.push_back(std::move(ball));
                    return Success{};
                  });
}

tremolo_status tremolo_cloth_scene_add_collider(tremolo_cloth_scene* scene,
                                                const tremolo_placed_collider* collider) {
  return with_all({{scene, "the scene"}, {collider, "the collider"}}, [&]() -> Status {
    if (Status s = need({{collider->collider, "the collider's shape"}}); !s) return s;
    tremolo::SceneCollider added;
    added.name = "collider " + std::to_string(scene->scene.colliders.size());
    added.shape = collider->collider->shape;
    const double* q = collider->quaternion;
    added.pose = {Vector3d(collider->position), Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
    added.friction = collider->friction;
    added.restitution = collider->restitution;
    scene->scene.colliders.push_back(std::move(added));
    return Success{};
  });
}

tremolo_status tremolo_cloth_create(const tremolo_cloth_scene* scene, tremolo_cloth_world** world) {
  return with_all({{scene, "the scene"}, {world, "the place for the world"}}, [&]() -> Status {
    Result<ClothWorld> made = ClothWorld::create(scene->scene);
    if (!made) return made.error();
    *world = new tremolo_cloth_world{std::move(*made)};
    return Success{};
  });
}

void tremolo_cloth_destroy(tremolo_cloth_world* world) {
  delete world;
}

tremolo_status tremolo_cloth_step(tremolo_cloth_world* world) {
  return with_all({{world, "the world of cloth"}}, [&] { return world->world.step(); });
}

double tremolo_cloth_time(const tremolo_cloth_world* world) {
  return world == nullptr ? 0.0 : world->world.time();
}

double tremolo_cloth_stability_limit(const tremolo_cloth_world* world) {
  return world == nullptr ? std::numeric_limits<double>::infinity()
                          : world->world.stability_limit();
}

size_t tremolo_cloth_particles(const tremolo_cloth_world* world, size_t cloth) {
  if (world == nullptr || cloth >= world->world.cloths()) return 0;
  return world->world.particles(cloth);
}

size_t tremolo_cloth_triangles(const tremolo_cloth_world* world, size_t cloth) {
  if (world == nullptr || cloth >= world->world.cloths()) return 0;
  return world->world.triangles(cloth).size();
}

tremolo_status tremolo_cloth_positions(const tremolo_cloth_world* world, size_t cloth, double* out,
                                       size_t length) {
  return copy_vectors(
      world, cloth, out, length,
      [cloth](const ClothWorld& of) -> const Eigen::VectorXd& { return of.positions(cloth); });
}

tremolo_status tremolo_cloth_velocities(const tremolo_cloth_world* world, size_t cloth, double* out,
                                        size_t length) {
  return copy_vectors(
      world, cloth, out, length,
      [cloth](const ClothWorld& of) -> const Eigen::VectorXd& { return of.velocities(cloth); });
}

tremolo_status tremolo_cloth_set_state(tremolo_cloth_world* world, size_t cloth,
                                       const double* positions, const double* velocities,
                                       size_t length) {
  return with_all(
      {{world, "the world of cloth"}, {positions, "the positions"}, {velocities, "the velocities"}},
      [&]() -> Status {
        if (Status s = need_cloth(world->world, cloth); !s) return s;
        return world->world.set_state(cloth, Eigen::VectorXd::Map(positions, length),
                                      Eigen::VectorXd::Map(velocities, length));
      });
}

tremolo_status tremolo_cloth_triangle_corners(const tremolo_cloth_world* world, size_t cloth,
                                              uint32_t* out, size_t length) {
  return with_all({{world, "the world of cloth"}}, [&]() -> Status {
    if (Status s = need_cloth(world->world, cloth); !s) return s;
    return fill_buffer(world->world.triangles(cloth), out, length);
  });
}

tremolo_status tremolo_cloth_hold(tremolo_cloth_world* world, size_t cloth, size_t particle,
                                  const double point[3]) {
  return with_all({{world, "the world of cloth"}, {point, "the point"}}, [&]() -> Status {
    if (Status s = need_cloth(world->world, cloth); !s) return s;
    return world->world.hold(cloth, particle, Vector3d(point));
  });
}

tremolo_status tremolo_cloth_let_go(tremolo_cloth_world* world, size_t cloth, size_t particle) {
  return with_all({{world, "the world of cloth"}}, [&]() -> Status {
    if (Status s = need_cloth(world->world, cloth); !s) return s;
    return world->world.let_go(cloth, particle);
  });
}

tremolo_status tremolo_cloth_ball(const tremolo_cloth_world* world, size_t ball, double position[3],
                                  double quaternion[4]) {
  return with_all({{world, "the world of cloth"}}, [&]() -> Status {
    const std::span<const ClothWorld::Ball> balls = world->world.balls();
    if (ball >= balls.size()) return usage_error("there is no ball " + std::to_string(ball));
    const Eigen::Quaterniond& turn = balls[ball].rotation;
    if (position != nullptr) Eigen::Map<Vector3d>(position, 3) = balls[ball].position;
    if (quaternion != nullptr)
      Eigen::Map<Eigen::Vector4d>(quaternion, 4) << turn.w(), turn.x(), turn.y(), turn.z();
    return Success{};
  });
}

tremolo_status tremolo_cloth_energy(const tremolo_cloth_world* world, double* kinetic,
                                    double* elastic, double* gravity) {
  return with_all({{world, "the world of cloth"}}, [&]() -> Status {
    const tremolo::ClothEnergy energy = world->world.energy();
    put(energy.kinetic, kinetic);
    put(energy.elastic, elastic);
    put(energy.gravity, gravity);
    return Success{};
  });
}
