// What a scene with [[bodies]] does, as a motion for `tremolo export`.
#include <filesystem>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/export/animate.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/io/exchange/world_tracks.h"
#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

// guests: null: the world has none.
Status step_to(SceneWorld& world, const MixedGuests* guests, std::int64_t step) {
  while (world.steps() < step) {
    const double from = world.time();
    for (const auto& [body, report] : world.step())
      return step_error(world.name(body), report, world.body(body).time());
    for (std::size_t i = 0; guests != nullptr && i < guests->size(); ++i)
      if (guests->failed(i))
        return Error{ErrorKind::kSolver,
                     fmt::format("body '{}': the step from t = {:.6g} s could not be solved: take "
                                 "a shorter step",
                                 guests->name(i), from)};
  }
  return Success{};
}

}  // namespace

Result<RecordedMotion> animate_world(const MixedFile& mixed, const FrameRange& range,
                                     bool colliders) {
  const SceneFile& file = mixed.file;
  const Result<FrameSteps> frames = frame_steps(range, file.scene.step, file.scene.duration);
  if (!frames) return frames.error();
  Result<SceneWorld> world = SceneWorld::create(file.scene, load_scene_model, mixed.has_guests());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  WorldGuests guests;
  if (mixed.has_guests())
    if (Status s = take(guests, add_guests(mixed.tets, mixed.cloths, file.path, *world)); !s)
      return s.error();
  WorldTracks tracks;
  Filmed filmed;
  filmed.name = std::filesystem::path(file.path).stem().string();
  filmed.time = [&] { return world->time(); };
  filmed.step_to = [&](std::int64_t step) { return step_to(*world, guests.guests, step); };
  filmed.record = [&](Recording& recording) {
    return tracks.record(things_of(*world, &guests, colliders), recording);
  };
  Result<RecordedMotion> motion = film(filmed, range, *frames, file.scene.duration);
  if (!motion) return error_of_file(file.path, motion.error());
  motion->left_out = tracks.left_out();
  return motion;
}

MotionSource world_motion(MixedFile mixed) {
  MotionSource source;
  const SceneFile& file = mixed.file;
  for (const SceneBody& body : file.scene.bodies) source.names.push_back(body.name);
  for (const std::string& name : guest_names(mixed)) source.names.push_back(name);
  for (const SceneCollider& collider : file.scene.colliders)
    source.scenery.push_back(collider.name);
  source.inputs = inputs_of(mixed);
  source.description =
      fmt::format("{:.4g} s in steps of {:.4g} ms", file.scene.duration, 1e3 * file.scene.step);
  if (mixed.has_guests()) {
    source.no_modes =
        "--modes applies only to bodies with a basis: tetrahedra and cloths have none";
    source.no_live =
        "--live applies only to bodies with a basis: a page's engine moves no tetrahedra or cloth";
  }
  source.record = [mixed = std::move(mixed)](const FrameRange& range, bool colliders) {
    return animate_world(mixed, range, colliders);
  };
  return source;
}

}  // namespace tremolo
