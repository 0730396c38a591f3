// runtime/tremolo_scene.h: scenes of bodies of all kinds from C.
#include "runtime/c/scene_c_api.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "runtime/c/nodal_c_api.h"

namespace {

using Eigen::Vector3d;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::need;
using tremolo::c_api::with_all;

// A model that calls added is named by its number after this, which begins no path.
constexpr char kGivenModel = '\0';

tremolo::SceneGravity constant(const Vector3d& gravity) {
  return {{}, {gravity}};
}

Result<tremolo_scene_body> complete_place(const tremolo_scene_body* place) {
  if (Status s = need({{place, "the body's place"}}); !s) return s.error();
  const auto full =
      tremolo::c_api::complete(place, tremolo_scene_body_init, "tremolo_scene_body_init");
  if (!full) return full.error();
  if (full->name == nullptr || *full->name == '\0')
    return usage_error("a body of a scene needs a name");
  return full;
}

tremolo::ContactOptions contact_of(const tremolo_scene_body& place) {
  tremolo::ContactOptions contact{.points = place.points,
                                  .margin = place.margin,
                                  .stiffness = place.stiffness,
                                  .friction = place.friction,
                                  .restitution = place.restitution};
  if (place.modulus != 0.0) contact.modulus = place.modulus;
  return contact;
}

// A reduced or rigid body without its model and its method.
Result<tremolo::SceneBody> body_at(const tremolo_scene_body* given) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  tremolo::SceneBody body;
  body.name = place->name;
  if (Status s = take(body.pose, tremolo::c_api::to_pose(place->position, place->quaternion)); !s)
    return s.error();
  body.velocity = Vector3d(place->velocity);
  body.spin = Vector3d(place->spin);
  body.contact = contact_of(*place);
  return body;
}

Status set_method(const tremolo_body_options* given, tremolo::SceneBody& body) {
  const Result<tremolo_body_options> full = tremolo::c_api::complete_body_options(given);
  if (!full) return full.error();
  if (full->integrator != nullptr) body.integrator = full->integrator;
  if (Status s = take(body.options, tremolo::c_api::to_integrator_options(*full)); !s) return s;
  return take(body.kind, tremolo::c_api::to_frame(full->frame));
}

// Bodies of one model share it.
std::string number_of(const tremolo::Model::Pointer& model,
                      std::vector<tremolo::Model::Pointer>& models) {
  const auto found = std::find(models.begin(), models.end(), model);
  const auto number = found - models.begin();
  if (found == models.end()) models.push_back(model);
  return kGivenModel + std::to_string(number);
}

Status add_reduced(tremolo_scene& scene, const tremolo_scene_body* place,
                   const tremolo_model& model, const tremolo_body_options* method,
                   const tremolo_collider* shape) {
  Result<tremolo::SceneBody> body = body_at(place);
  if (!body) return body.error();
  if (Status s = set_method(method, *body); !s) return s;
  if (shape != nullptr) body->contact.shape = shape->shape;
  body->model = number_of(model.pointer, scene.models);
  scene.scene.bodies.push_back(std::move(*body));
  return Success{};
}

Status add_rigid(tremolo_scene& scene, const tremolo_scene_body* place,
                 const tremolo_collider& shape, double mass) {
  Result<tremolo::SceneBody> body = body_at(place);
  if (!body) return body.error();
  body->kind = tremolo::FrameKind::kFree;
  body->rigid.emplace();
  body->rigid->shape = shape.shape;
  body->rigid->mass = mass;
  scene.scene.bodies.push_back(std::move(*body));
  return Success{};
}

Status add_tets(tremolo_scene& scene, const tremolo_scene_body* given,
                const tremolo_tets_options* options) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  const auto full =
      tremolo::c_api::complete(options, tremolo_tets_options_init, "tremolo_tets_options_init");
  if (!full) return full.error();
  if (Status s = need({{full->file, "the body's file"}}); !s) return s;
  tremolo::TetSceneBody body;
  body.name = place->name;
  body.model = full->file;
  if (Status s = take(body.pose, tremolo::c_api::to_pose(place->position, place->quaternion)); !s)
    return s;
  body.velocity = Vector3d(place->velocity);
  body.spin = Vector3d(place->spin);
  if (Status s = take(body.options, tremolo::c_api::to_tets_options(*full)); !s) return s;
  body.contact = contact_of(*place);
  body.friction = body.contact.friction;
  scene.tets.push_back(std::move(body));
  return Success{};
}

Status add_cloth(tremolo_scene& scene, const tremolo_scene_body* given, const char* method,
                 const tremolo_cloth_options* options, tremolo::ClothPin pin) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  const auto full =
      tremolo::c_api::complete(options, tremolo_cloth_options_init, "tremolo_cloth_options_init");
  if (!full) return full.error();
  tremolo::ClothSceneBody body;
  body.scene = scene.around;
  if (method != nullptr) body.scene.integrator = method;
  tremolo::SceneCloth cloth = tremolo::c_api::to_cloth(*full, place->name);
  if (!pin.particles.empty()) cloth.pins.push_back(std::move(pin));
  body.scene.cloths = {std::move(cloth)};
  body.velocity = Vector3d(place->velocity);
  const tremolo::ContactOptions contact = contact_of(*place);
  body.contact.stiffness = contact.stiffness;
  body.contact.modulus = contact.modulus;
  scene.cloths.push_back(std::move(body));
  return Success{};
}

Status set_vector(const char* name, const double value[3], Vector3d& out) {
  const Vector3d wanted(value);
  if (!wanted.allFinite()) return usage_error(std::string(name) + " is not finite");
  out = wanted;
  return Success{};
}

}  // namespace

tremolo_status tremolo_scene_create(double step, tremolo_scene** scene) {
  return with_all({{scene, "the place for the scene"}}, [&]() -> Status {
    auto made = std::make_unique<tremolo_scene>();
    made->scene.step = made->around.options.step = step;
    made->scene.gravity = made->around.gravity = constant({0.0, 0.0, -9.81});
    *scene = made.release();
    return Success{};
  });
}

void tremolo_scene_destroy(tremolo_scene* scene) {
  delete scene;
}

tremolo_status tremolo_scene_set_gravity(tremolo_scene* scene, const double gravity[3]) {
  return with_all({{scene, "the scene"}, {gravity, "gravity"}}, [&]() -> Status {
    Vector3d wanted;
    if (Status s = set_vector("gravity", gravity, wanted); !s) return s;
    scene->scene.gravity = scene->around.gravity = constant(wanted);
    for (tremolo::ClothSceneBody& body : scene->cloths) body.scene.gravity = constant(wanted);
    return Success{};
  });
}

tremolo_status tremolo_scene_set_wind(tremolo_scene* scene, const double wind[3]) {
  return with_all({{scene, "the scene"}, {wind, "the wind"}}, [&]() -> Status {
    Vector3d wanted;
    if (Status s = set_vector("the wind", wind, wanted); !s) return s;
    scene->around.wind = wanted;
    scene->around.gust = 0.0;
    for (tremolo::ClothSceneBody& body : scene->cloths) {
      body.scene.wind = wanted;
      body.scene.gust = 0.0;
    }
    return Success{};
  });
}

void tremolo_scene_body_init(tremolo_scene_body* place) {
  if (place == nullptr) return;
  const tremolo::ContactOptions usual;
  *place = {.size = sizeof(tremolo_scene_body),
            .points = usual.points,
            .name = nullptr,
            .position = {0.0, 0.0, 0.0},
            .quaternion = {1.0, 0.0, 0.0, 0.0},
            .velocity = {0.0, 0.0, 0.0},
            .spin = {0.0, 0.0, 0.0},
            .friction = usual.friction,
            .restitution = usual.restitution,
            .margin = usual.margin,
            .stiffness = usual.stiffness,
            .modulus = 0.0};
}

tremolo_status tremolo_scene_add_reduced(tremolo_scene* scene, const tremolo_scene_body* place,
                                         const tremolo_model* model,
                                         const tremolo_body_options* method,
                                         const tremolo_collider* shape) {
  return with_all({{scene, "the scene"}, {model, "the model"}},
                  [&] { return add_reduced(*scene, place, *model, method, shape); });
}

tremolo_status tremolo_scene_add_rigid(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const tremolo_collider* shape, double mass) {
  return with_all({{scene, "the scene"}, {shape, "the shape"}},
                  [&] { return add_rigid(*scene, place, *shape, mass); });
}

tremolo_status tremolo_scene_add_tets(tremolo_scene* scene, const tremolo_scene_body* place,
                                      const tremolo_tets_options* options) {
  return with_all({{scene, "the scene"}, {options, "the options"}},
                  [&] { return add_tets(*scene, place, options); });
}

tremolo_status tremolo_scene_add_cloth(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const char* method, const tremolo_cloth_options* options,
                                       const size_t* pins, size_t count) {
  return with_all({{scene, "the scene"}}, [&]() -> Status {
    tremolo::ClothPin pin;
    if (count > 0) {
      if (Status s = need({{pins, "the pins"}}); !s) return s;
      pin.particles.assign(pins, pins + count);
    }
    return add_cloth(*scene, place, method, options, std::move(pin));
  });
}

tremolo_status tremolo_scene_add_collider(tremolo_scene* scene,
                                          const tremolo_placed_collider* collider) {
  return with_all({{scene, "the scene"}, {collider, "the collider"}}, [&]() -> Status {
    tremolo_placed_collider still = *collider;
    std::copy_n(still.position, 3, still.next_position);
    std::copy_n(still.quaternion, 4, still.next_quaternion);
    std::vector<tremolo::PlacedCollider> placed;
    if (Status s = tremolo::c_api::place_colliders(&still, 1, placed); !s) return s;
    const tremolo::PlacedCollider& one = placed.front();
    tremolo::SceneCollider made;
    made.name = "collider " + std::to_string(scene->scene.colliders.size() + 1);
    made.shape = one.shape;
    made.pose = one.start;
    made.friction = one.friction;
    made.restitution = one.restitution;
    scene->scene.colliders.push_back(std::move(made));
    return Success{};
  });
}
