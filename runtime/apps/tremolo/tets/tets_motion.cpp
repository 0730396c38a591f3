#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_progress.h"
#include "runtime/apps/tremolo/tets/tets_commands.h"
#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/motion/tet_group.h"

namespace tremolo {
namespace {

AnimatedShape tets_shape(const TetsKind& kind) {
  const TetsSurface& drawn = kind.surface->rest();
  AnimatedShape shape;
  shape.name = std::filesystem::path(kind.path).stem().string();
  RenderSurface& surface = shape.surface;
  surface.vertices = drawn.vertices;
  surface.triangles = drawn.triangles;
  surface.uvs = drawn.uvs;
  surface.sources = drawn.sources;
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.material_of.assign(surface.triangles.size(), 0);
  surface.objects = surface.materials = {shape.name};
  return shape;
}

Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& places) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& place : places) sum += place;
  return sum / static_cast<double>(places.size());
}

// The pose for which the sum of |x - pose X|^2 is least.
Pose nearest_pose(const std::vector<Eigen::Vector3d>& rest,
                  const std::vector<Eigen::Vector3d>& places) {
  const Eigen::Vector3d rest_mean = mean_of(rest), mean = mean_of(places);
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i)
    products += (places[i] - mean) * (rest[i] - rest_mean).transpose();
  const Eigen::Matrix3d turn = nearest_rotation(products);
  return {mean - turn * rest_mean, Eigen::Quaterniond(turn).normalized()};
}

void record_tets(const TetsBodies& bodies, Animation& animation, double time, const TetScene& scene,
                 const Scenery& scenery) {
  animation.times.push_back(time);
  std::vector<Eigen::Vector3d> places;
  std::vector<Eigen::Vector3f> normals;
  const std::size_t count = bodies.group->size();
  for (std::size_t i = 0; i < count; ++i) {
    AnimatedBody& body = animation.bodies[i];
    const std::vector<Eigen::Vector3d>& rest = animation.shapes[body.shape].surface.vertices;
    places.resize(rest.size());
    normals.resize(rest.size());
    bodies.kind(i).surface->place(bodies.group->body(i).positions(), places, normals);
    const Pose pose = nearest_pose(rest, places);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Eigen::Vector3d local = pose.rotation.conjugate() * (places[k] - pose.position);
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        body.displacements.push_back(local[axis] - rest[k][axis]);
    }
    body.poses.push_back(pose);
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
    record_tets(*bodies, motion.animation, time, scene, scenery);
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
