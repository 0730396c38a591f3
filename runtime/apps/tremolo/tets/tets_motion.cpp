#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/tets/tets_commands.h"
#include "runtime/bodies/tets/motion/tet_group.h"
#include "runtime/io/exchange/nodal_tracks.h"

namespace tremolo {
namespace {

void record_all(const TetsBodies& bodies, Animation& animation, double time, const TetScene& scene,
                const Scenery& scenery) {
  animation.times.push_back(time);
  const std::size_t count = bodies.group->size();
  for (std::size_t i = 0; i < count; ++i) {
    AnimatedBody& body = animation.bodies[i];
    record_tets(bodies.kind(i), bodies.group->body(i).positions(), animation.shapes[body.shape],
                body);
  }
  for (std::size_t k = 0; k < scenery.colliders.size(); ++k)
    animation.bodies[count + k].poses.push_back(scene.colliders[scenery.colliders[k]].pose);
}

// A body a body, a shape a file.
std::set<std::string> add_tets(const TetScene& scene, const TetsBodies& bodies,
                               Animation& animation) {
  std::set<std::string> taken;
  for (const TetsKind& kind : bodies.kinds) animation.shapes.push_back(tets_shape(kind));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    AnimatedBody body;
    body.name = scene.bodies[i].name;
    body.shape = bodies.kind_of[i];
    taken.insert(body.name);
    animation.bodies.push_back(std::move(body));
  }
  return taken;
}

Result<RecordedMotion> animate_tets(const TetScene& scene, const FrameRange& range,
                                    bool colliders) {
  const Result<FrameSteps> frames = frame_steps(range, scene.step, scene.duration);
  if (!frames) return frames.error();
  Result<TetsBodies> bodies = make_tets_bodies(scene);
  if (!bodies) return bodies.error();
  RecordedMotion motion;
  motion.offset = frames->offset;
  motion.even_step = frames->even_step;
  motion.animation.rate = range.rate;
  std::set<std::string> taken = add_tets(scene, *bodies, motion.animation);
  const Scenery scenery =
      colliders ? add_colliders(scene.colliders, true, taken, motion.animation) : Scenery{};
  motion.left_out = scenery.left_out;
  ToldProgress progress(std::filesystem::path(scene.path).stem().string(), scene.duration);
  std::vector<TetStepReport> reports(scene.bodies.size());
  TetBound bound;
  bodies->group->find_touches();
  bound.look(*bodies->group);
  std::int64_t made = 0;
  for (const std::int64_t step : frames->steps) {
    for (; made < step; ++made) {
      const double from = scene.step * static_cast<double>(made);
      if (!bodies->group->step(reports))
        return Error{
            ErrorKind::kSolver,
            fmt::format("{}: the step from t = {:.6g} s could not be solved", scene.path, from)};
      if (!bound.look(*bodies->group))
        return Error{
            ErrorKind::kBound,
            fmt::format("{}: in the step from t = {:.6g} s the energy of the bodies, {:.3g} "
                        "J, became more than {:g} times all that was put in",
                        scene.path, from, bound.energy(), kEnergyBound)};
    }
    const double time = scene.step * static_cast<double>(step);
    record_all(*bodies, motion.animation, time, scene, scenery);
    progress.reached(time);
  }
  return motion;
}

}  // namespace

MotionSource tets_motion(TetScene scene) {
  MotionSource source;
  for (const TetSceneBody& body : scene.bodies) source.names.push_back(body.name);
  for (const SceneCollider& collider : scene.colliders) source.scenery.push_back(collider.name);
  source.inputs = inputs_of(scene);
  source.description = fmt::format("{:.4g} s of {} bodies of tetrahedra in steps of {:.4g} ms",
                                   scene.duration, scene.bodies.size(), 1e3 * scene.step);
  source.no_modes = "--modes applies only to bodies with a basis: tetrahedra have none";
  source.no_live =
      "--live applies only to bodies with a basis: a page's engine moves no tetrahedra";
  source.record = [scene = std::move(scene)](const FrameRange& range, bool colliders) {
    return animate_tets(scene, range, colliders);
  };
  return source;
}

}  // namespace tremolo
