#include "runtime/apps/tremolo/export/animate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "runtime/apps/tremolo/export/nodal_tracks.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

Result<FrameSteps> frame_steps(const FrameRange& range, double h, double duration) {
  if (!(range.rate > 0.0) || !std::isfinite(range.rate))
    return content_error(fmt::format("--rate {}: must be positive and finite", range.rate));
  const double to = range.to.value_or(duration);
  if (!(range.from >= 0.0) || !(to >= range.from))
    return content_error(
        fmt::format("--from {} --to {}: the range must begin at 0 or later and end behind that",
                    range.from, to));
  if (to > duration * (1.0 + 1e-9))
    return content_error(
        fmt::format("--to {}: the run lasts {} s; --duration makes it longer", to, duration));
  if (range.rate * h > 1.0 + 1e-9)
    return content_error(
        fmt::format("--rate {}: a second has only {:.6g} steps of {} s; --step {:.6g} makes more",
                    range.rate, 1.0 / h, h, 1.0 / range.rate));
  // A frame that the range's end just reaches is one of them, whatever the last digit says.
  const double count = std::floor((to - range.from) * range.rate + 1e-6) + 1.0;
  if (!(count < 1e8)) return content_error(fmt::format("{} frames are too many", count));
  FrameSteps frames;
  frames.even_step = 1.0 / (range.rate * std::ceil(1.0 / (range.rate * h) - 1e-9));
  const std::int64_t last = std::llround(duration / h);
  for (std::int64_t k = 0; static_cast<double>(k) < count; ++k) {
    const double wanted = range.from + static_cast<double>(k) / range.rate;
    const std::int64_t step = std::min<std::int64_t>(std::llround(wanted / h), last);
    if (!frames.steps.empty() && step <= frames.steps.back()) break;  // after the last step
    frames.steps.push_back(step);
    frames.offset = std::max(frames.offset, std::abs(static_cast<double>(step) * h - wanted));
  }
  return frames;
}

namespace {

Status check_together(const std::vector<BodyScene>& bodies) {
  const BodyScene& first = bodies.front();
  for (const BodyScene& one : bodies)
    if (one.step() != first.step() || one.file.scene.duration != first.file.scene.duration)
      return content_error(one.file.path + ": bodies '" + first.body().name + "' and '" +
                           one.body().name +
                           "' have other steps or durations, and frames are of all bodies: say "
                           "--step and --duration");
  return Success{};
}

Error step_error(const std::string& name, const StepReport& report, double time) {
  return {error_kind(report.failure), "body '" + name + "': " + failure_message(report, time)};
}

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

// The radius of drawn planes: the largest extent of the bodies in all frames, with a margin.
double reach_of(const Animation& animation, const Eigen::Vector3d& centre) {
  double reach = 0.0;
  for (const AnimatedBody& body : animation.bodies) {
    if (body.collider) continue;
    const AnimatedShape& shape = animation.shape_of(body);
    const BoundingBox box = bounding_box(shape.surface.vertices);
    const double size = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
    for (const Pose& pose : body.poses)
      reach = std::max(reach, (pose.position - centre).norm() + size);
  }
  return 1.25 * reach;
}

// colliders: numbers, in the world, of the recorded ones, which follow the bodies.
void widen_planes(const SceneWorld& world, const std::vector<std::size_t>& colliders,
                  Animation& animation) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!std::holds_alternative<PlaneShape>(world.colliders()[colliders[k]].shape)) continue;
    const AnimatedBody& plane = animation.bodies[world.size() + k];
    const double reach = reach_of(animation, plane.poses[0].position);
    for (Eigen::Vector3d& x : animation.shapes[plane.shape].surface.vertices) x *= reach;
  }
}

// The tracks of a world in a recording: its bodies, then of its colliders those that can be drawn.
struct WorldTracks {
  std::size_t first = 0;  // the first body's
  std::vector<std::size_t> colliders;
  std::vector<std::string> left_out;
};

Result<WorldTracks> add_tracks(const SceneWorld& world, bool colliders, Recording& recording) {
  WorldTracks tracks;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const auto added = recording.add(world.body(i), world.name(i));
    if (!added) return added.error();
    if (i == 0) tracks.first = *added;
  }
  for (std::size_t k = 0; colliders && k < world.colliders().size(); ++k) {
    std::string name = world.scene().colliders[k].name;
    std::optional<AnimatedShape> shape = collider_shape(world.colliders()[k].shape, name, 1.0);
    if (!shape) {
      tracks.left_out.push_back(name);
      continue;
    }
    while (world.find(name)) name += "-collider";
    if (const auto added = recording.add(std::move(*shape), name); !added) return added.error();
    tracks.colliders.push_back(k);
  }
  return tracks;
}

Status record_frame(const SceneWorld& world, const WorldTracks& tracks, Recording& recording) {
  for (std::size_t i = 0; i < world.size(); ++i)
    if (Status s = recording.record(tracks.first + i, world.body(i)); !s) return s;
  for (std::size_t k = 0; k < tracks.colliders.size(); ++k) {
    // The collider at the end of the last step; before the first step, at its start.
    const PlacedCollider& placed = world.colliders()[tracks.colliders[k]];
    const Pose& pose = world.steps() == 0 ? placed.start : placed.end;
    if (Status s = recording.record(tracks.first + world.size() + k, {}, std::span(&pose, 1)); !s)
      return s;
  }
  return Success{};
}

// Worlds of one step and duration, each by itself; guests and colliders are those of the first.
struct Film {
  std::vector<SceneWorld> worlds;
  WorldGuests guests;
  std::string name;  // of the progress
  bool colliders = false;
};

Result<RecordedMotion> record(Film& film, const FrameRange& range, const FrameSteps& frames,
                              double duration) {
  Result<GuestTracks> guest_tracks = GuestTracks::create(film.guests);
  if (!guest_tracks) return guest_tracks.error();
  Recording recording(range.rate);
  std::vector<WorldTracks> tracks(film.worlds.size());
  for (std::size_t w = 0; w < tracks.size(); ++w)
    if (Status s = take(tracks[w], add_tracks(film.worlds[w], film.colliders, recording)); !s)
      return s.error();
  const SceneWorld& first = film.worlds.front();
  ToldProgress progress(film.name, duration);
  for (const std::int64_t step : frames.steps) {
    for (SceneWorld& world : film.worlds)
      if (Status s = step_to(world, film.guests.guests, step); !s) return s.error();
    if (Status s = recording.begin_frame(first.time()); !s) return s.error();
    for (std::size_t w = 0; w < tracks.size(); ++w)
      if (Status s = record_frame(film.worlds[w], tracks[w], recording); !s) return s.error();
    guest_tracks->record();
    progress.reached(first.time());
  }
  RecordedMotion motion;
  motion.offset = frames.offset;
  motion.even_step = frames.even_step;
  motion.left_out = tracks.front().left_out;
  if (Status s = take(motion.animation, recording.animation()); !s) return s.error();
  guest_tracks->add_to(motion.animation);
  widen_planes(first, tracks.front().colliders, motion.animation);
  return motion;
}

}  // namespace

Result<RecordedMotion> animate_bodies(const std::vector<BodyScene>& bodies,
                                      const FrameRange& range) {
  if (Status s = check_together(bodies); !s) return s.error();
  const Scene& first = bodies.front().file.scene;
  const Result<FrameSteps> frames = frame_steps(range, first.step, first.duration);
  if (!frames) return frames.error();
  std::vector<RunInput> inputs(bodies.size());  // they outlive the worlds
  Film film;
  film.name = first.bodies.front().name;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (Status s = take(inputs[i], prepare_run(bodies[i])); !s) return s.error();
    Result<SceneWorld> world = world_of_one(inputs[i]);
    if (!world) return world.error();
    film.worlds.push_back(std::move(*world));
  }
  return record(film, range, *frames, first.duration);
}

Result<RecordedMotion> animate_world(const MixedFile& mixed, const FrameRange& range,
                                     bool colliders) {
  const SceneFile& file = mixed.file;
  const Result<FrameSteps> frames = frame_steps(range, file.scene.step, file.scene.duration);
  if (!frames) return frames.error();
  Result<SceneWorld> world = SceneWorld::create(file.scene, load_scene_model, mixed.has_guests());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  Film film{{}, {}, std::filesystem::path(file.path).stem().string(), colliders};
  if (mixed.has_guests())
    if (Status s = take(film.guests, add_guests(mixed.tets, mixed.cloths, file.path, *world)); !s)
      return s.error();
  film.worlds.push_back(std::move(*world));
  Result<RecordedMotion> motion = record(film, range, *frames, file.scene.duration);
  if (!motion) return error_of_file(file.path, motion.error());
  return motion;
}

}  // namespace tremolo
