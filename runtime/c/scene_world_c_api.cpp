// runtime/tremolo_scene.h: worlds of bodies of all kinds from C.
#include <algorithm>
#include <charconv>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/text.h"
#include "runtime/c/scene_c_api.h"

bool tremolo::c_api::look_at(const tremolo_world& world, std::size_t guest, GuestBound& bound) {
  const GuestEnergy now = energy_of(*world.made.guests, guest);
  const ContactSums& sums = world.made.guests->sums(guest);
  return bound.look(now.kinetic + now.elastic, now.gravity, sums.work + sums.hand + sums.joint);
}

namespace {

using tremolo::Result;
using tremolo::SceneWorld;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::look_at;
using tremolo::c_api::with_all;

constexpr const char* kWorld = "the world";

std::vector<Eigen::Index> drawn_particles(const tremolo::ClothParts& parts) {
  std::vector<Eigen::Index> particles(parts.drawn ? parts.drawn->vertices.size()
                                                  : parts.particles());
  for (std::size_t v = 0; v < particles.size(); ++v) {
    const bool renumbered = parts.drawn && !parts.drawn->sources.empty();
    const std::size_t vertex = renumbered ? static_cast<std::size_t>(parts.drawn->sources[v]) : v;
    particles[v] = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
  }
  return particles;
}

void begin_guests(tremolo_world& world) {
  const tremolo::MixedGuests& guests = *world.made.guests;
  for (std::size_t i = 0; i < guests.size(); ++i) {
    tremolo_world::Guest& guest = world.guests.emplace_back();
    if (const tremolo::ClothStep* step = guests.cloth(i)) {
      const tremolo::SceneCloth& cloth = step->body().cloth();
      guest.driven = cloth.drag > 0.0 || !cloth.pins.empty();
      guest.particles = drawn_particles(step->body().model().parts());
    }
    (void)look_at(world, i, guest.bound);
  }
}

Status check_names(const tremolo_scene& scene) {
  std::set<std::string> names;
  std::vector<std::string> all;
  for (const tremolo::SceneBody& body : scene.scene.bodies) all.push_back(body.name);
  for (const tremolo::TetSceneBody& body : scene.tets) all.push_back(body.name);
  for (const tremolo::ClothSceneBody& body : scene.cloths) all.push_back(body.name());
  for (const std::string& name : all)
    if (!names.insert(name).second)
      return tremolo::content_error("two bodies are called '" + name + "'");
  if (!scene.tets.empty() && scene.scene.gravity.values.size() > 1)
    return tremolo::content_error(
        "gravity that changes in time does not act on bodies of tetrahedra");
  return Success{};
}

Result<tremolo::Model::Pointer> model_of(const tremolo_scene& scene,
                                         const tremolo::SceneBody& body) {
  if (body.model.empty() || body.model.front() != '\0') return tremolo::load_scene_model(body);
  std::size_t number = 0;
  std::from_chars(body.model.data() + 1, body.model.data() + body.model.size(), number);
  return scene.models[number];
}

// The guests of the scene with its step and gravity.
Status add_guests_of(const tremolo_scene& scene, tremolo_world& world) {
  std::vector<tremolo::TetSceneBody> tets = scene.tets;
  for (tremolo::TetSceneBody& body : tets) {
    body.options.step = scene.scene.step;
    body.options.gravity = scene.scene.gravity.at(0.0);
  }
  if (Status s = take(world.made, add_guests(tets, scene.cloths, scene.path, world.world)); !s)
    return s;
  begin_guests(world);
  return Success{};
}

Status make_world(const tremolo_scene& given, std::uint32_t threads, tremolo_world** world) {
  if (Status s = check_names(given); !s) return s;
  const bool guests = !given.tets.empty() || !given.cloths.empty();
  tremolo::Scene scene = given.scene;
  for (const tremolo::TetSceneBody& body : given.tets) scene.guests.insert(body.name);
  for (const tremolo::ClothSceneBody& body : given.cloths) scene.guests.insert(body.name());
  Result<SceneWorld> made = SceneWorld::create(
      scene, [&given](const tremolo::SceneBody& body) { return model_of(given, body); }, guests);
  if (!made) return made.error();
  auto handle = std::make_unique<tremolo_world>(tremolo_world{std::move(*made)});
  if (Status s = handle->world.set_threads(threads); !s) return s;
  if (guests)
    if (Status s = add_guests_of(given, *handle); !s) return s;
  *world = handle.release();
  return Success{};
}

// One step. An error names all bodies that failed in it.
Status step(tremolo_world& world) {
  std::string failed;
  tremolo::ErrorKind kind = tremolo::ErrorKind::kSolver;
  const auto add = [&](const std::string& name, tremolo::ErrorKind why, const std::string& reason) {
    kind = why;
    failed += (failed.empty() ? "" : "; ") + name + ": " + reason;
  };
  for (const SceneWorld::Failure& failure : world.world.step())
    add(world.world.name(failure.body), tremolo::error_kind(failure.report.failure),
        tremolo::failure_message(failure.report, world.world.time()));
  const std::string time = tremolo::number_text(world.world.time());
  for (std::size_t i = 0; i < world.guests.size(); ++i) {
    tremolo_world::Guest& guest = world.guests[i];
    if (guest.over) continue;
    const std::string& name = world.made.guests->name(i);
    guest.over = true;
    if (world.made.guests->failed(i))
      add(name, tremolo::ErrorKind::kSolver, "the step to t = " + time + " s could not be solved");
    else if (!guest.driven && !look_at(world, i, guest.bound))
      add(name, tremolo::ErrorKind::kBound,
          "at t = " + time + " s the energy is more than " +
              tremolo::number_text(tremolo::kEnergyBound) + " times all that was put in");
    else
      guest.over = false;
  }
  if (failed.empty()) return Success{};
  return tremolo::Error{kind, failed};
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
  return with_all({{world, kWorld}}, [&]() -> Status {
    if (count < 0) return usage_error("the number of steps is " + std::to_string(count));
    for (int64_t k = 0; k < count; ++k) {
      const Status made = step(*world);
      if (done != nullptr) *done = k + 1;
      if (!made) return made;
    }
    return Success{};
  });
}

double tremolo_world_time(const tremolo_world* world) {
  return world == nullptr ? 0.0 : world->world.time();
}

int64_t tremolo_world_steps(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world.steps();
}

tremolo_status tremolo_world_save(const tremolo_world* world, void* bytes, size_t capacity,
                                  size_t* size) {
  return with_all({{world, kWorld}, {size, "the place for the size"}}, [&]() -> Status {
    const std::vector<std::byte> saved = world->world.save();
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
  return with_all({{world, kWorld}, {bytes, "the bytes"}}, [&]() -> Status {
    if (Status s = world->world.restore(std::span(static_cast<const std::byte*>(bytes), size)); !s)
      return s;
    for (std::size_t i = 0; i < world->guests.size(); ++i) {
      world->guests[i].bound = {};
      world->guests[i].over = world->made.guests->failed(i);
      (void)look_at(*world, i, world->guests[i].bound);
    }
    return Success{};
  });
}
