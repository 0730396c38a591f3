#include "runtime/program/tets/inspect_tets.h"

#include "runtime/program/output/scene_places.h"
#include "runtime/program/output/tell.h"
#include "runtime/program/run/run_body.h"

namespace tremolo {
namespace {

Result<ScenePlaces> places_of(const TetScene& scene) {
  const Result<TetsBodies> bodies = make_tets_bodies(scene);
  if (!bodies) return error_of_file(scene.path, value_error(bodies.error()));
  ScenePlaces places{scene.path, "a world of tetrahedra", scene.step, scene.duration, true, {}, {},
                     {}};
  places.warnings = keyframe_warnings({}, scene.colliders);
  std::vector<Eigen::Vector3f> normals;
  for (std::size_t i = 0; i < bodies->group->size(); ++i) {
    const TetSceneBody& wanted = scene.bodies[i];
    PlacedBody body{wanted.name, "tets", wanted.model, wanted.pose, {}, {}};
    const std::size_t vertices = bodies->kind(i).surface->rest().vertices.size();
    body.surface.resize(vertices);
    normals.resize(vertices);
    bodies->kind(i).surface->place(bodies->group->body(i).positions(), body.surface, normals);
    places.bodies.push_back(std::move(body));
  }
  for (const SceneCollider& collider : scene.colliders)
    places.colliders.push_back({collider.name, collider.shape, collider.pose});
  return places;
}

}  // namespace

int inspect_tets_command(const TetScene& scene, bool json) {
  const Result<ScenePlaces> places = places_of(scene);
  if (!places) return report_error(places.error());
  print_places(*places, json);
  return 0;
}

}  // namespace tremolo
