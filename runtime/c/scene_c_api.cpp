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
using tremolo::c_api::cloth_body;
using tremolo::c_api::reduced_body;
using tremolo::c_api::rigid_body;
using tremolo::c_api::scene_collider;
using tremolo::c_api::scene_joint;
using tremolo::c_api::tets_body;
using tremolo::c_api::with_all;

tremolo::SceneGravity constant(const Vector3d& gravity) {
  return {{}, {gravity}};
}

// Adds what `made` has to the list.
template <class Value>
Status keep(Result<Value> made, std::vector<Value>& list) {
  if (!made) return made.error();
  list.push_back(std::move(*made));
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
  return with_all({{scene, "the scene"}, {model, "the model"}}, [&] {
    return keep(reduced_body(place, *model, method, shape, scene->models), scene->scene.bodies);
  });
}

tremolo_status tremolo_scene_add_rigid(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const tremolo_collider* shape, double mass) {
  return with_all({{scene, "the scene"}, {shape, "the shape"}},
                  [&] { return keep(rigid_body(place, *shape, mass), scene->scene.bodies); });
}

tremolo_status tremolo_scene_add_tets(tremolo_scene* scene, const tremolo_scene_body* place,
                                      const tremolo_tets_options* options) {
  return with_all({{scene, "the scene"}, {options, "the options"}},
                  [&] { return keep(tets_body(place, options), scene->tets); });
}

tremolo_status tremolo_scene_add_cloth(tremolo_scene* scene, const tremolo_scene_body* place,
                                       const char* method, const tremolo_cloth_options* options,
                                       const size_t* pins, size_t count) {
  return with_all({{scene, "the scene"}}, [&] {
    return keep(cloth_body(scene->around, place, method, options, pins, count), scene->cloths);
  });
}

tremolo_status tremolo_scene_add_collider(tremolo_scene* scene,
                                          const tremolo_placed_collider* collider) {
  return with_all({{scene, "the scene"}, {collider, "the collider"}}, [&] {
    std::vector<tremolo::SceneCollider>& all = scene->scene.colliders;
    return keep(scene_collider(*collider, all.size()), all);
  });
}

tremolo_status tremolo_scene_add_joint(tremolo_scene* scene, const tremolo_joint* joint) {
  return with_all({{scene, "the scene"}, {joint, "the joint"}},
                  [&] { return keep(scene_joint(*joint), scene->scene.joints); });
}
