#include "runtime/program/cloth/cloth_motion.h"

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "runtime/cloth/cloth_parts.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/exchange/collider_shape.h"
#include "runtime/program/cloth/run_cloth.h"
#include "runtime/program/export/export_motion.h"
#include "runtime/program/export/scenery.h"
#include "runtime/program/run/run_body.h"
#include "runtime/program/run/run_progress.h"

namespace tremolo {
namespace {

// The cloth as it is cut, flat, which its vertices are displaced from.
Result<AnimatedShape> cloth_shape(const SceneCloth& cloth) {
  const Result<ClothParts> parts = make_cloth_parts(cloth);
  if (!parts) return parts.error();
  AnimatedShape shape;
  shape.name = cloth.name;
  RenderSurface& surface = shape.surface;
  surface.vertices.resize(static_cast<std::size_t>(parts->x.size()) / 3);
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    surface.vertices[i] = parts->x.segment<3>(static_cast<Eigen::Index>(3 * i));
  surface.triangles = parts->triangles;
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.material_of.assign(surface.triangles.size(), 0);
  surface.objects = surface.materials = {cloth.name};
  return shape;
}

Result<Scenery> add_tracks_of(const ClothScene& scene, bool colliders, Animation& animation) {
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
  return colliders ? add_colliders(scene.colliders, taken, animation) : Scenery{};
}

void record_cloths(const ClothWorld& world, const Scenery& scenery, Animation& animation) {
  animation.times.push_back(world.time());
  for (std::size_t i = 0; i < world.cloths(); ++i) {
    AnimatedBody& body = animation.bodies[i];
    const std::vector<Eigen::Vector3d>& rest = animation.shapes[body.shape].surface.vertices;
    const Eigen::VectorXd& x = world.positions(i);
    for (std::size_t k = 0; k < 3 * rest.size(); ++k)
      body.displacements.push_back(x[static_cast<Eigen::Index>(k)] - rest[k / 3][k % 3]);
    body.poses.emplace_back();
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
                                      bool colliders) {
  const ClothScene& scene = file.scene;
  const Result<FrameSteps> frames = frame_steps(range, scene.options.step, scene.duration);
  if (!frames) return frames.error();
  Result<ClothWorld> world = ClothWorld::create(scene);
  if (!world) return error_of_file(file.path, value_error(world.error()));
  RecordedMotion motion;
  motion.offset = frames->offset;
  motion.even_step = frames->even_step;
  motion.animation.rate = range.rate;
  const Result<Scenery> scenery = add_tracks_of(scene, colliders, motion.animation);
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

class ClothMotion : public MotionSource {
 public:
  explicit ClothMotion(ClothFile file) : file_(std::move(file)) {}

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const SceneCloth& cloth : file_.scene.cloths) names.push_back(cloth.name);
    return names;
  }

  std::vector<NamedFile> inputs() const override { return inputs_of(file_); }

  std::string told() const override {
    return fmt::format("{:.4g} s by `{}` in steps of {:.4g} ms", file_.scene.duration,
                       file_.scene.integrator, 1e3 * file_.scene.options.step);
  }

  Status check(const MotionOutputs& outputs) const override {
    if (outputs.modes > 0) return usage_error("--modes is of bodies: a cloth has none");
    if (!outputs.extras.live.empty())
      return usage_error("--live is of bodies: a page's engine moves no cloth");
    return Success{};
  }

  Result<RecordedMotion> record(const FrameRange& range, bool colliders) const override {
    return animate_cloths(file_, range, colliders);
  }

 private:
  ClothFile file_;
};

}  // namespace

std::unique_ptr<MotionSource> cloth_motion(ClothFile file) {
  return std::make_unique<ClothMotion>(std::move(file));
}

}  // namespace tremolo
