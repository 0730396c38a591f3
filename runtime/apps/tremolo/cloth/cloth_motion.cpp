#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "runtime/apps/tremolo/cloth/cloth_commands.h"
#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/io/exchange/nodal_tracks.h"
#include "runtime/io/exchange/recording.h"

namespace tremolo {
namespace {

Result<Scenery> add_tracks_of(const ClothScene& scene, bool colliders, bool planes,
                              Animation& animation) {
  std::set<std::string> taken;
  for (const SceneCloth& cloth : scene.cloths) {
    Result<AnimatedShape> shape = cloth_shape(cloth);
    if (!shape) return shape.error();
    AnimatedBody body;
    body.name = cloth.name;
    body.shape = animation.shapes.size();
    taken.insert(cloth.name);
    animation.shapes.push_back(std::move(*shape));
    animation.bodies.push_back(std::move(body));
  }
  for (const SceneBall& ball : scene.balls)
    add_scenery(*collider_shape(SphereShape{ball.radius}, ball.name, 1.0), ball.name, taken,
                animation);
  return colliders ? add_colliders(scene.colliders, planes, taken, animation) : Scenery{};
}

void record_cloths(const ClothWorld& world, const Scenery& scenery, Animation& animation) {
  animation.times.push_back(world.time());
  for (std::size_t i = 0; i < world.cloths(); ++i) {
    AnimatedBody& body = animation.bodies[i];
    record_cloth(world.model(i).parts(), world.positions(i), animation.shapes[body.shape], body);
  }
  std::size_t next = world.cloths();
  for (const ClothWorld::Ball& ball : world.balls()) {
    Pose pose;
    pose.position = ball.position;
    pose.rotation = ball.rotation;
    animation.bodies[next++].poses.push_back(pose);
  }
  for (const std::size_t k : scenery.colliders)
    animation.bodies[next++].poses.push_back(world.collider_pose(k));
}

Result<RecordedMotion> animate_cloths(const ClothFile& file, const FrameRange& range,
                                      bool colliders, bool planes) {
  const ClothScene& scene = file.scene;
  const Result<FrameSteps> frames = frame_steps(range, scene.options.step, scene.duration);
  if (!frames) return frames.error();
  Result<ClothWorld> world = ClothWorld::create(scene);
  if (!world) return error_of_file(file.path, value_error(world.error()));
  RecordedMotion motion;
  motion.offset = frames->offset;
  motion.even_step = frames->even_step;
  motion.animation.rate = range.rate;
  const Result<Scenery> scenery = add_tracks_of(scene, colliders, planes, motion.animation);
  if (!scenery) return scenery.error();
  motion.left_out = scenery->left_out;
  ToldProgress progress(std::filesystem::path(file.path).stem().string(), scene.duration);
  for (const std::int64_t step : frames->steps) {
    while (world->steps() < step)
      if (Status s = world->step(); !s) return error_of_file(file.path, s.error());
    record_cloths(*world, *scenery, motion.animation);
    progress.reached(world->time());
  }
  return motion;
}

constexpr double kRoom = 1.25;  // from a scene to the next, in its width

// The extent of the cloths along x in the first frame, m.
std::pair<double, double> cloths_extent(const Animation& animation) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const AnimatedBody& body : animation.bodies) {
    const std::vector<Eigen::Vector3d>& rest = animation.shape_of(body).surface.vertices;
    for (std::size_t i = 0; i < rest.size() && !body.displacements.empty(); ++i) {
      const double x = body.poses[0].position.x() + rest[i].x() + body.displacements[3 * i];
      low = std::min(low, x);
      high = std::max(high, x);
    }
  }
  return {low, high};
}

// Returns the name, with "-2" appended until it is unique, and adds it to `taken`.
std::string free_name(std::string name, std::set<std::string>& taken) {
  while (!taken.insert(name).second) name += "-2";
  return name;
}

// Adds the second recording's bodies to the right of the first's.
void put_beside(RecordedMotion& first, RecordedMotion second) {
  Animation& all = first.animation;
  const auto [low, high] = cloths_extent(all);
  const auto [its_low, its_high] = cloths_extent(second.animation);
  const double aside = low + kRoom * (high - low) - its_low;
  std::set<std::string> taken;
  for (const AnimatedBody& body : all.bodies) taken.insert(body.name);
  for (AnimatedBody& body : second.animation.bodies) {
    body.name = free_name(std::move(body.name), taken);
    body.shape += all.shapes.size();
    for (Pose& pose : body.poses) pose.position.x() += aside;
  }
  std::move(second.animation.shapes.begin(), second.animation.shapes.end(),
            std::back_inserter(all.shapes));
  std::move(second.animation.bodies.begin(), second.animation.bodies.end(),
            std::back_inserter(all.bodies));
  first.left_out.insert(first.left_out.end(), second.left_out.begin(), second.left_out.end());
}

// The recordings of all scenes, next to each other.
Result<RecordedMotion> animate_side_by_side(const std::vector<ClothFile>& files,
                                            const FrameRange& range, bool colliders) {
  Result<RecordedMotion> motion = animate_cloths(files.front(), range, colliders, true);
  for (std::size_t i = 1; motion && i < files.size(); ++i) {
    Result<RecordedMotion> next = animate_cloths(files[i], range, colliders, false);
    if (!next) return next.error();
    if (next->animation.times != motion->animation.times)
      return content_error(files[i].path +
                           ": its frames have other times than those of the first scene: say "
                           "--step and --duration");
    put_beside(*motion, std::move(*next));
  }
  return motion;
}

}  // namespace

MotionSource cloth_motion(std::vector<ClothFile> files) {
  MotionSource source;
  std::set<std::string> taken;
  std::string methods;
  for (const ClothFile& file : files) {
    const ClothScene& scene = file.scene;
    for (const SceneCloth& cloth : scene.cloths)
      source.names.push_back(free_name(cloth.name, taken));
    for (const SceneBall& ball : scene.balls) source.scenery.push_back(ball.name);
    for (const SceneCollider& collider : scene.colliders) source.scenery.push_back(collider.name);
    for (NamedFile& input : inputs_of(file)) source.inputs.push_back(std::move(input));
    methods += (methods.empty() ? "`" : "; beside it by `") + scene.integrator + "`";
  }
  const ClothScene& first = files.front().scene;
  source.description = fmt::format("{:.4g} s in steps of {:.4g} ms by {}", first.duration,
                                   1e3 * first.options.step, methods);
  source.no_modes = "--modes applies only to bodies: a cloth has none";
  source.no_live = "--live applies only to bodies: a page's engine moves no cloth";
  source.record = [files = std::move(files)](const FrameRange& range, bool colliders) {
    return animate_side_by_side(files, range, colliders);
  };
  return source;
}

}  // namespace tremolo
