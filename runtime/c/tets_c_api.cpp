// runtime/tremolo_tets.h: bodies of tetrahedra from C.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "common/text.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/c/c_api.h"
#include "runtime/c/nodal_c_api.h"
#include "runtime/tremolo_tets.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
// gravity, step: of all bodies, set when the world is made.
struct tremolo_tets_scene {
  tremolo::TetBodiesScene scene;
  double step = 0.0;
  Eigen::Vector3d gravity = {0.0, 0.0, -9.81};
};
// vertices, normals, reports: buffers for the results of a call.
struct tremolo_tets_world {
  tremolo::TetsBodies bodies;
  std::vector<tremolo::TetStepReport> reports;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3f> normals;
};
// NOLINTEND(readability-identifier-naming)

namespace {

using Eigen::Vector3d;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::TetBody;
using tremolo::TetsBodies;
using tremolo::usage_error;
using tremolo::c_api::fill_buffer;
using tremolo::c_api::need_buffer;
using tremolo::c_api::put;
using tremolo::c_api::to_pose;
using tremolo::c_api::with_all;

constexpr double kTurnSlack = 1e-6;  // of a quaternion's length

size_t bodies_of(const tremolo_tets_world* world) {
  return world == nullptr ? 0 : world->bodies.group->size();
}

// Runs action(world, body) -> Status; kUsage if the body does not exist.
template <class World, class Action>
tremolo_status with_body(World* world, size_t body, const Action& action) noexcept {
  return with_all({{world, "the world of tetrahedra"}}, [&]() -> Status {
    const size_t count = bodies_of(world);
    if (body < count) return action();
    return usage_error("there are " + std::to_string(count) + " bodies, no body " +
                       std::to_string(body));
  });
}

Result<tremolo::DegreeKind> to_degree(int32_t degree) {
  switch (degree) {
    case TREMOLO_TETS_LINEAR:
      return tremolo::DegreeKind::kLinear;
    case TREMOLO_TETS_QUADRATIC:
      return tremolo::DegreeKind::kQuadratic;
    case TREMOLO_TETS_ADAPTIVE:
      return tremolo::DegreeKind::kAdaptive;
    default:
      return usage_error("there is no degree " + std::to_string(degree));
  }
}

}  // namespace

Result<tremolo::TetBodyOptions> tremolo::c_api::to_tets_options(const tremolo_tets_options& given) {
  tremolo::TetBodyOptions options;
  if (given.method != nullptr)
    if (Status s = take(options.method, tremolo::parse_tet_method(given.method)); !s)
      return s.error();
  if (Status s = take(options.degree.kind, to_degree(given.degree)); !s) return s.error();
  options.alpha = given.alpha;
  options.beta = given.beta;
  options.tolerance = given.tolerance;
  options.max_iterations = given.max_iterations;
  constexpr tremolo::UnsolvedStep kUnsolved[] = {tremolo::UnsolvedStep::kCut,
                                                 tremolo::UnsolvedStep::kTake,
                                                 tremolo::UnsolvedStep::kTakeContact};
  if (given.take_unsolved < 0 || given.take_unsolved > 2)
    return usage_error("take_unsolved is " + std::to_string(given.take_unsolved) +
                       ", must be 0, 1 or 2");
  options.unsolved = kUnsolved[given.take_unsolved];
  options.drag = given.drag;
  return options;
}

Result<tremolo::Pose> tremolo::c_api::to_pose(const double position[3],
                                              const double quaternion[4]) {
  const Eigen::Quaterniond turn(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
  if (!(std::abs(turn.norm() - 1.0) <= kTurnSlack))
    return usage_error("a body's quaternion has the length " + number_text(turn.norm()));
  return Pose{Vector3d(position), turn.normalized()};
}

namespace {

Result<tremolo::TetSceneBody> to_body(const tremolo_tets_options& given, size_t number) {
  tremolo::TetSceneBody body;
  body.name = std::to_string(number);
  body.model = given.file;
  if (Status s = take(body.pose, to_pose(given.position, given.quaternion)); !s) return s.error();
  body.velocity = Vector3d(given.velocity);
  body.spin = Vector3d(given.spin);
  if (!body.pose.position.allFinite() || !body.velocity.allFinite() || !body.spin.allFinite())
    return usage_error("a body's position, velocity or spin is not finite");
  if (!(given.friction >= 0.0) || !std::isfinite(given.friction))
    return usage_error("a body's friction is " + tremolo::number_text(given.friction) +
                       ", must be finite and not negative");
  body.friction = given.friction;
  if (Status s = take(body.options, tremolo::c_api::to_tets_options(given)); !s) return s.error();
  return body;
}

Result<tremolo::TetHand> hand_of(const tremolo_tets_world& world, size_t body, size_t vertex) {
  const tremolo::TetsKind& kind = world.bodies.kind(body);
  if (vertex >= kind.surface->vertices())
    return usage_error("the drawn surface has " + std::to_string(kind.surface->vertices()) +
                       " vertices, no vertex " + std::to_string(vertex));
  return hand_at(*kind.model, kind.surface->rest(), vertex);
}

// The numbers of bodies whose step failed.
std::string not_made(std::span<const tremolo::TetStepReport> reports) {
  std::string numbers;
  for (size_t i = 0; i < reports.size(); ++i)
    if (!reports[i].converged) numbers += (numbers.empty() ? "" : ", ") + std::to_string(i);
  return numbers;
}

}  // namespace

tremolo_status tremolo_tets_scene_create(double step, tremolo_tets_scene** scene) {
  return with_all({{scene, "the place for the scene"}}, [&]() -> Status {
    auto made = std::make_unique<tremolo_tets_scene>();
    made->step = step;
    *scene = made.release();
    return Success{};
  });
}

void tremolo_tets_scene_destroy(tremolo_tets_scene* scene) {
  delete scene;
}

tremolo_status tremolo_tets_scene_set_gravity(tremolo_tets_scene* scene, const double gravity[3]) {
  return with_all({{scene, "the scene"}, {gravity, "gravity"}}, [&]() -> Status {
    if (!Vector3d(gravity).allFinite()) return usage_error("gravity is not finite");
    scene->gravity = Vector3d(gravity);
    return Success{};
  });
}

tremolo_status tremolo_tets_scene_set_sleep(tremolo_tets_scene* scene, double speed, double time) {
  return with_all({{scene, "the scene"}}, [&]() -> Status {
    tremolo::TetGroupOptions wanted = scene->scene.group;
    wanted.sleep_speed = speed;
    wanted.sleep_time = time;
    if (Status s = check(wanted); !s) return s;
    scene->scene.group = wanted;
    return Success{};
  });
}

tremolo_status tremolo_tets_scene_set_threads(tremolo_tets_scene* scene, uint32_t threads) {
  return with_all({{scene, "the scene"}}, [&]() -> Status {
    if (threads < 1 || threads > 256)
      return usage_error("threads are " + std::to_string(threads) + ", must be 1 to 256");
    scene->scene.group.threads = threads;
    return Success{};
  });
}

void tremolo_tets_options_init(tremolo_tets_options* options) {
  if (options == nullptr) return;
  const tremolo::TetSceneBody usual;
  *options = {.size = sizeof(tremolo_tets_options),
              .degree = TREMOLO_TETS_ADAPTIVE,
              .file = nullptr,
              .method = nullptr,
              .position = {0.0, 0.0, 0.0},
              .quaternion = {1.0, 0.0, 0.0, 0.0},
              .velocity = {0.0, 0.0, 0.0},
              .spin = {0.0, 0.0, 0.0},
              .alpha = usual.options.alpha,
              .beta = usual.options.beta,
              .tolerance = usual.options.tolerance,
              .friction = usual.friction,
              .max_iterations = usual.options.max_iterations,
              .take_unsolved = 2,
              .drag = usual.options.drag};
}

tremolo_status tremolo_tets_scene_add(tremolo_tets_scene* scene,
                                      const tremolo_tets_options* options, size_t* body) {
  return with_all({{scene, "the scene"}, {options, "the options"}}, [&]() -> Status {
    const auto full =
        tremolo::c_api::complete(options, tremolo_tets_options_init, "tremolo_tets_options_init");
    if (!full) return full.error();
    if (Status s = tremolo::c_api::need({{full->file, "the body's file"}}); !s) return s;
    const size_t number = scene->scene.bodies.size();
    Result<tremolo::TetSceneBody> made = to_body(*full, number);
    if (!made) return made.error();
    scene->scene.bodies.push_back(std::move(*made));
    put(number, body);
    return Success{};
  });
}

tremolo_status tremolo_tets_scene_add_collider(tremolo_tets_scene* scene,
                                               const tremolo_placed_collider* collider) {
  return with_all({{scene, "the scene"}, {collider, "the collider"}}, [&]() -> Status {
    std::vector<tremolo::PlacedCollider> placed;
    if (Status s = tremolo::c_api::place_colliders(collider, 1, placed); !s) return s;
    tremolo::SceneCollider added;
    added.name = "collider " + std::to_string(scene->scene.colliders.size());
    added.shape = placed[0].shape;
    added.pose = placed[0].start;
    added.friction = placed[0].friction;
    scene->scene.colliders.push_back(std::move(added));
    return Success{};
  });
}

tremolo_status tremolo_tets_create(const tremolo_tets_scene* scene, tremolo_tets_world** world) {
  return with_all({{scene, "the scene"}, {world, "the place for the world"}}, [&]() -> Status {
    tremolo::TetBodiesScene ready = scene->scene;
    for (tremolo::TetSceneBody& body : ready.bodies) {
      body.options.step = scene->step;
      body.options.gravity = scene->gravity;
    }
    Result<TetsBodies> made = make_tets_bodies(ready);
    if (!made) return made.error();
    auto ready_world = std::make_unique<tremolo_tets_world>();
    ready_world->bodies = std::move(*made);
    ready_world->reports.resize(ready.bodies.size());
    *world = ready_world.release();
    return Success{};
  });
}

void tremolo_tets_destroy(tremolo_tets_world* world) {
  delete world;
}

tremolo_status tremolo_tets_step(tremolo_tets_world* world) {
  return with_all({{world, "the world of tetrahedra"}}, [&]() -> Status {
    if (world->bodies.group->step(world->reports)) return Success{};
    return tremolo::Error{
        tremolo::ErrorKind::kSolver,
        "the step of these bodies could not be solved: " + not_made(world->reports)};
  });
}

double tremolo_tets_time(const tremolo_tets_world* world) {
  return bodies_of(world) == 0 ? 0.0 : world->bodies.group->body(0).time();
}

size_t tremolo_tets_bodies(const tremolo_tets_world* world) {
  return bodies_of(world);
}

size_t tremolo_tets_vertices(const tremolo_tets_world* world, size_t body) {
  return body < bodies_of(world) ? world->bodies.kind(body).surface->vertices() : 0;
}

size_t tremolo_tets_triangles(const tremolo_tets_world* world, size_t body) {
  return body < bodies_of(world) ? world->bodies.kind(body).surface->rest().triangles.size() : 0;
}

size_t tremolo_tets_points(const tremolo_tets_world* world, size_t body) {
  return body < bodies_of(world) ? world->bodies.kind(body).model->nodes() : 0;
}

tremolo_status tremolo_tets_surface(tremolo_tets_world* world, size_t body, float* positions,
                                    float* normals, size_t length) {
  return with_body(world, body, [&]() -> Status {
    const tremolo::TetSurface& surface = *world->bodies.kind(body).surface;
    for (const float* buffer : {positions, normals})
      if (buffer != nullptr)
        if (Status s = need_buffer(buffer, length, 3 * surface.vertices()); !s) return s;
    world->vertices.resize(surface.vertices());
    world->normals.resize(surface.vertices());
    surface.place(world->bodies.group->body(body).positions(), world->vertices, world->normals);
    if (positions != nullptr)
      for (const Vector3d& x : world->vertices)
        for (const double value : x) *positions++ = static_cast<float>(value);
    if (normals != nullptr)
      for (const Eigen::Vector3f& n : world->normals)
        normals = std::copy(n.begin(), n.end(), normals);
    return Success{};
  });
}

tremolo_status tremolo_tets_triangle_corners(const tremolo_tets_world* world, size_t body,
                                             uint32_t* out, size_t length) {
  return with_body(world, body, [&]() -> Status {
    return fill_buffer(world->bodies.kind(body).surface->rest().triangles, out, length);
  });
}

tremolo_status tremolo_tets_positions(const tremolo_tets_world* world, size_t body, double* out,
                                      size_t length) {
  return with_body(world, body, [&] {
    return fill_buffer(world->bodies.group->body(body).positions(), out, length);
  });
}

tremolo_status tremolo_tets_velocities(const tremolo_tets_world* world, size_t body, double* out,
                                       size_t length) {
  return with_body(world, body, [&] {
    return fill_buffer(world->bodies.group->body(body).velocities(), out, length);
  });
}

tremolo_status tremolo_tets_set_state(tremolo_tets_world* world, size_t body,
                                      const double* positions, const double* velocities,
                                      size_t length) {
  return with_body(world, body, [&]() -> Status {
    const size_t size = 3 * tremolo_tets_points(world, body);
    for (const double* buffer : {positions, velocities})
      if (Status s = need_buffer(buffer, length, size); !s) return s;
    return world->bodies.group->set_state(body, Eigen::VectorXd::Map(positions, size),
                                          Eigen::VectorXd::Map(velocities, size));
  });
}

tremolo_status tremolo_tets_pull(tremolo_tets_world* world, size_t body, size_t vertex,
                                 double stiffness, double damping, const double point[3],
                                 const double velocity[3]) {
  return with_body(world, body, [&]() -> Status {
    if (Status s = tremolo::c_api::need({{point, "the hand's point"}}); !s) return s;
    Result<tremolo::TetHand> hand = hand_of(*world, body, vertex);
    if (!hand) return hand.error();
    hand->stiffness = stiffness;
    hand->damping = damping;
    hand->point = Vector3d(point);
    if (velocity != nullptr) hand->velocity = Vector3d(velocity);
    return world->bodies.group->set_hand(body, *hand);
  });
}

tremolo_status tremolo_tets_let_go(tremolo_tets_world* world, size_t body) {
  return with_body(world, body, [&] { return world->bodies.group->set_hand(body, std::nullopt); });
}

tremolo_status tremolo_tets_suitable(tremolo_tets_world* world, size_t body, size_t vertex,
                                     double* stiffness, double* damping) {
  return with_body(world, body, [&]() -> Status {
    Result<tremolo::TetHand> hand = hand_of(*world, body, vertex);
    if (!hand) return hand.error();
    if (Status s = suit_springs(world->bodies.group->body(body), *hand); !s) return s;
    put(hand->stiffness, stiffness);
    put(hand->damping, damping);
    return Success{};
  });
}

tremolo_status tremolo_tets_look(const tremolo_tets_world* world, size_t body, int32_t* asleep,
                                 double* quadratic_share) {
  return with_body(world, body, [&]() -> Status {
    const tremolo::TetGroup& group = *world->bodies.group;
    put(group.asleep(body) ? 1 : 0, asleep);
    put(group.body(body).system().quadratic_share(), quadratic_share);
    return Success{};
  });
}

tremolo_status tremolo_tets_energy(tremolo_tets_world* world, double* kinetic, double* elastic,
                                   double* gravity, double* contact) {
  return with_all({{world, "the world of tetrahedra"}}, [&]() -> Status {
    double sums[4] = {};
    tremolo::TetGroup& group = *world->bodies.group;
    for (size_t i = 0; i < group.size(); ++i) {
      TetBody& body = group.body(i);
      sums[0] += body.kinetic_energy();
      sums[1] += body.elastic_energy();
      sums[2] += body.gravity_energy();
      sums[3] += group.contact(i).look().energy;
    }
    double* out[] = {kinetic, elastic, gravity, contact};
    for (int k = 0; k < 4; ++k) put(sums[k], out[k]);
    return Success{};
  });
}
