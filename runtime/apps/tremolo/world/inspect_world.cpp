#include "common/units.h"
#include "runtime/apps/tremolo/measure/tets_log.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/world/scene_world.h"
#include "runtime/world/world_guests.h"

namespace tremolo {
namespace {

Result<std::vector<Eigen::Vector3d>> boundary_of(const Body& body) {
  std::vector<double> numbers(3 * body.model().surface().rest.size());
  if (Status s = body.surface_positions(std::span<double>(numbers), SurfaceKind::kBoundary); !s)
    return s.error();
  std::vector<Eigen::Vector3d> places;
  for (std::size_t v = 0; v < numbers.size(); v += 3) places.emplace_back(numbers.data() + v);
  return places;
}

Result<PlacedBody> placed(const SceneBody& wanted, const Body& body) {
  PlacedBody place{wanted.name, kind_name(wanted), solid_name(wanted), body.pose(), {}, {}};
  if (Status s = take(place.surface, boundary_of(body)); !s) return s.error();
  if (body.model().modes() == 0) return place;
  const double first = hertz(body.model().lambda()(0));
  if (first > 0.0) place.first_mode = first;
  return place;
}

Status add_bodies(const SceneWorld& world, ScenePlaces& places) {
  for (std::size_t i = 0; i < world.size(); ++i) {
    Result<PlacedBody> body = placed(world.scene().bodies[i], world.body(i));
    if (!body) return body.error();
    const std::string warning = body->first_mode
                                    ? step_warning(*body->first_mode, world.step_size(),
                                                   "body '" + body->name + "': its ", "a step of ")
                                    : std::string();
    if (!warning.empty()) places.warnings.push_back(warning);
    places.bodies.push_back(std::move(*body));
  }
  return Success{};
}

// Bodies of tetrahedra follow the others, then cloths.
Status add_guest_places(const MixedFile& mixed, SceneWorld& world, ScenePlaces& places) {
  if (!mixed.has_guests()) return Success{};
  const Result<WorldGuests> guests = add_guests(mixed.tets, mixed.cloths, mixed.file.path, world);
  if (!guests) return guests.error();
  for (std::size_t i = 0; i < mixed.tets.size(); ++i)
    places.bodies.push_back(
        placed_tets(mixed.tets[i], *guests->kind(i).surface, guests->guests->tets(i)->body()));
  for (std::size_t i = 0; i < mixed.cloths.size(); ++i) {
    const ClothBody& body = guests->guests->cloth(guests->of_cloth(i))->body();
    PlacedBody place{mixed.cloths[i].name(), "cloth", body.cloth().file, {}, {}, {}};
    for (Eigen::Index k = 0; k < body.state().x.size(); k += 3)
      place.surface.push_back(body.state().x.segment<3>(k));
    places.bodies.push_back(std::move(place));
  }
  return Success{};
}

Result<ScenePlaces> places_of(const MixedFile& mixed) {
  const SceneFile& file = mixed.file;
  Result<SceneWorld> world = SceneWorld::create(file.scene, load_scene_model, mixed.has_guests());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  ScenePlaces places{
      file.path, "a world of bodies", world->step_size(), file.scene.duration, true, {}, {}, {}};
  places.warnings = keyframe_warnings(file.scene.bodies, file.scene.colliders);
  if (Status s = add_bodies(*world, places); !s) return s.error();
  if (Status s = add_guest_places(mixed, *world, places); !s) return s.error();
  for (std::size_t c = 0; c < world->colliders().size(); ++c) {
    const PlacedCollider& collider = world->colliders()[c];
    places.colliders.push_back({file.scene.colliders[c].name, collider.shape, collider.start});
  }
  return places;
}

Result<ScenePlaces> places_of(const std::vector<BodyScene>& bodies) {
  const SceneFile& first = bodies.front().file;
  ScenePlaces places{
      first.path, "bodies, each by itself", first.scene.step, first.scene.duration, false, {}, {},
      {}};
  for (const BodyScene& scene : bodies) {
    const Result<RunInput> input = load_body(scene);
    if (!input) return input.error();
    const Result<SceneWorld> made = world_of_one(*input);
    if (!made) return made.error();
    if (Status s = add_bodies(*made, places); !s) return s.error();
  }
  return places;
}

int print_or_fail(const Result<ScenePlaces>& places, bool json) {
  if (!places) return report_error(places.error());
  print_places(*places, json);
  return 0;
}

}  // namespace

int inspect_world_command(const MixedFile& mixed, bool json) {
  return print_or_fail(places_of(mixed), json);
}

int inspect_bodies_command(const std::vector<BodyScene>& bodies, bool json) {
  return print_or_fail(places_of(bodies), json);
}

}  // namespace tremolo
