// runtime/tremolo_scene.h: worlds of bodies of all kinds from C: their steps, and what comes and
// goes.
#include "runtime/c/world_c_api.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/processor.h"
#include "runtime/c/nodal_c_api.h"

namespace {

using tremolo::Pose;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::World;
using tremolo::WorldBody;
using tremolo::c_api::Argument;
using tremolo::c_api::put;
using tremolo::c_api::with_all;
using tremolo::c_api::with_body;
using tremolo::c_api::with_world;

constexpr Argument kNoPlace{nullptr, "the place for the number"};

Status make_world(const tremolo_scene& scene, std::uint32_t threads, tremolo_world** world) {
  auto handle = std::make_unique<tremolo_world>();
  handle->models = scene.models;
  handle->around = scene.around;
  const auto source = [&scene](const tremolo::SceneBody& body) {
    return tremolo::c_api::model_of(scene.models, body);
  };
  Result<std::unique_ptr<World>> made =
      World::create({scene.path, scene.scene, scene.tets, scene.cloths, source}, threads);
  if (!made) return made.error();
  handle->world = std::move(*made);
  *world = handle.release();
  return Success{};
}

// Adds to the world what make() -> Result<a body of a scene> returns.
template <class Make>
tremolo_status add(tremolo_world* world, std::initializer_list<Argument> further,
                   tremolo_body_id* body, const Make& make) noexcept {
  return with_world(world, further, [&](World& all) -> Status {
    if (Status s = tremolo::c_api::need({{body, "the place for the id"}}); !s) return s;
    auto wanted = make();
    if (!wanted) return wanted.error();
    const auto added = [&]() -> Result<WorldBody> {
      if constexpr (std::is_same_v<decltype(wanted), Result<tremolo::SceneBody>>)
        return all.add(*wanted, [world](const tremolo::SceneBody& of) {
          return tremolo::c_api::model_of(world->models, of);
        });
      else
        return all.add(std::move(*wanted));
    }();
    if (!added) return added.error();
    *body = tremolo::c_api::id_of(*added);
    return Success{};
  });
}

Status keep(const Result<std::size_t>& number, std::uint32_t* out) {
  if (!number) return number.error();
  *out = static_cast<std::uint32_t>(*number);
  return Success{};
}

}  // namespace

tremolo_status tremolo_world_create(const tremolo_scene* scene, uint32_t threads,
                                    tremolo_world** world) {
  return with_all({{scene, "the scene"}, {world, "the place for the world"}},
                  [&] { return make_world(*scene, threads, world); });
}

void tremolo_world_destroy(tremolo_world* world) {
  delete world;
}

tremolo_status tremolo_world_step(tremolo_world* world, int64_t count, int64_t* done) {
  if (done != nullptr) *done = 0;
  return with_world(world, {}, [&](World& all) { return all.step(count, done); });
}

double tremolo_world_time(const tremolo_world* world) {
  return world == nullptr ? 0.0 : world->world->time();
}

int64_t tremolo_world_steps(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world->steps();
}

tremolo_status tremolo_world_add_reduced(tremolo_world* world, const tremolo_scene_body* place,
                                         const tremolo_model* model,
                                         const tremolo_body_options* method,
                                         const tremolo_collider* shape, tremolo_body_id* body) {
  return add(world, {{model, "the model"}}, body, [&] {
    return tremolo::c_api::reduced_body(place, *model, method, shape, world->models);
  });
}

tremolo_status tremolo_world_add_rigid(tremolo_world* world, const tremolo_scene_body* place,
                                       const tremolo_collider* shape, double mass,
                                       tremolo_body_id* body) {
  return add(world, {{shape, "the shape"}}, body,
             [&] { return tremolo::c_api::rigid_body(place, *shape, mass); });
}

tremolo_status tremolo_world_add_tets(tremolo_world* world, const tremolo_scene_body* place,
                                      const tremolo_tets_options* options, tremolo_body_id* body) {
  return add(world, {{options, "the options"}}, body,
             [&] { return tremolo::c_api::tets_body(place, options); });
}

tremolo_status tremolo_world_add_cloth(tremolo_world* world, const tremolo_scene_body* place,
                                       const char* method, const tremolo_cloth_options* options,
                                       const size_t* pins, size_t count, tremolo_body_id* body) {
  return add(world, {}, body, [&] {
    return tremolo::c_api::cloth_body(world->around, place, method, options, pins, count);
  });
}

tremolo_status tremolo_world_remove(tremolo_world* world, tremolo_body_id body) {
  return with_body(world, body, {}, [](World& all, WorldBody known) { return all.remove(known); });
}

tremolo_status tremolo_world_move(tremolo_world* world, tremolo_body_id body,
                                  const double position[3], const double quaternion[4]) {
  return with_body(world, body, {{position, "the position"}, {quaternion, "the quaternion"}},
                   [&](World& all, WorldBody known) -> Status {
                     const Result<Pose> pose = tremolo::c_api::to_pose(position, quaternion);
                     return pose ? all.move(known, *pose) : Status(pose.error());
                   });
}

tremolo_status tremolo_world_add_collider(tremolo_world* world,
                                          const tremolo_placed_collider* collider,
                                          uint32_t* number) {
  return with_world(
      world, {{collider, "the collider"}, {number, kNoPlace.name}}, [&](World& all) -> Status {
        const Result<tremolo::SceneCollider> wanted =
            tremolo::c_api::scene_collider(*collider, all.own().scene().colliders.size());
        if (!wanted) return wanted.error();
        return keep(all.add_collider(*wanted), number);
      });
}

tremolo_status tremolo_world_move_collider(tremolo_world* world, uint32_t collider,
                                           const double position[3], const double quaternion[4]) {
  return with_world(world, {{position, "the position"}, {quaternion, "the quaternion"}},
                    [&](World& all) -> Status {
                      const Result<Pose> pose = tremolo::c_api::to_pose(position, quaternion);
                      return pose ? all.move_collider(collider, *pose) : Status(pose.error());
                    });
}

tremolo_status tremolo_world_remove_collider(tremolo_world* world, uint32_t collider) {
  return with_world(world, {}, [&](World& all) { return all.remove_collider(collider); });
}

tremolo_status tremolo_world_find_collider(const tremolo_world* world, const char* name,
                                           uint32_t* collider) {
  return with_world(world, {{name, "the name"}, {collider, kNoPlace.name}},
                    [&](const World& all) -> Status {
                      const auto found = all.find_collider(name);
                      if (!found)
                        return usage_error("there is no collider '" + std::string(name) + "'");
                      *collider = static_cast<std::uint32_t>(*found);
                      return Success{};
                    });
}

size_t tremolo_world_colliders(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world->own().scene().colliders.size();
}

tremolo_status tremolo_world_add_joint(tremolo_world* world, const tremolo_joint* joint,
                                       uint32_t* number) {
  return with_world(
      world, {{joint, "the joint"}, {number, kNoPlace.name}}, [&](World& all) -> Status {
        const Result<tremolo::SceneJoint> wanted = tremolo::c_api::scene_joint(*joint);
        return wanted ? keep(all.add_joint(*wanted), number) : Status(wanted.error());
      });
}

tremolo_status tremolo_world_remove_joint(tremolo_world* world, uint32_t joint) {
  return with_world(world, {}, [&](World& all) { return all.remove_joint(joint); });
}

tremolo_status tremolo_world_joint(const tremolo_world* world, uint32_t joint, double force[3],
                                   double* energy, int32_t* holds) {
  return with_world(world, {}, [&](const World& all) -> Status {
    if (joint >= all.own().scene().joints.size())
      return usage_error("there is no joint " + std::to_string(joint));
    const tremolo::Joint* known = all.joint(joint);
    put(known != nullptr ? known->force : Eigen::Vector3d(Eigen::Vector3d::Zero()), force);
    put(known != nullptr ? known->energy : 0.0, energy);
    put(known != nullptr ? 1 : 0, holds);
    return Success{};
  });
}

tremolo_status tremolo_world_add_load(tremolo_world* world, tremolo_body_id body,
                                      const tremolo_load* load) {
  return with_body(world, body, {{load, "the load"}}, [&](World& all, WorldBody known) -> Status {
    const Result<tremolo::SceneLoad> wanted = tremolo::c_api::scene_load(*load);
    return wanted ? all.add_load(known, *wanted) : Status(wanted.error());
  });
}

tremolo_status tremolo_world_set_filter(tremolo_world* world, tremolo_filter filter, void* user) {
  return with_world(world, {}, [&](World& all) -> Status {
    if (filter == nullptr) {
      all.set_filter({});
      return Success{};
    }
    all.set_filter([filter, user](WorldBody a, WorldBody b) {
      return filter(user, tremolo::c_api::id_of(a), tremolo::c_api::id_of(b)) != 0;
    });
    return Success{};
  });
}

tremolo_status tremolo_world_set_threads(tremolo_world* world, uint32_t threads) {
  return with_world(world, {}, [&](World& all) { return all.set_threads(threads); });
}

tremolo_status tremolo_world_set_jobs(tremolo_world* world, uint32_t workers, tremolo_run_jobs run,
                                      void* user) {
  return with_world(world, {}, [&](World& all) -> Status {
    if (run == nullptr) {
      all.set_jobs(std::nullopt);
      return Success{};
    }
    if (workers == 0) return usage_error("there must be a worker at least");
    if (workers > tremolo::kMostThreads)
      return usage_error(std::to_string(workers) + " workers: at most " +
                         std::to_string(tremolo::kMostThreads));
    all.set_jobs(tremolo::BodyGroup::Jobs{
        workers, [run, user](std::size_t count, tremolo_job job, void* data) {
          run(user, count, job, data);
        }});
    return Success{};
  });
}

tremolo_status tremolo_world_save(const tremolo_world* world, void* bytes, size_t capacity,
                                  size_t* size) {
  return with_world(world, {{size, "the place for the size"}}, [&](const World& all) -> Status {
    const std::vector<std::byte> saved = all.save();
    if (bytes != nullptr) {
      if (capacity < saved.size())
        return usage_error("the buffer holds " + std::to_string(capacity) +
                           " bytes, the state takes " + std::to_string(saved.size()));
      std::copy(saved.begin(), saved.end(), static_cast<std::byte*>(bytes));
    }
    *size = saved.size();
    return Success{};
  });
}

tremolo_status tremolo_world_restore(tremolo_world* world, const void* bytes, size_t size) {
  return with_world(world, {{bytes, "the bytes"}}, [&](World& all) {
    return all.restore(std::span(static_cast<const std::byte*>(bytes), size));
  });
}
