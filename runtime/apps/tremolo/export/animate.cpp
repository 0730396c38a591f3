#include "runtime/apps/tremolo/export/animate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

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

}  // namespace

Error step_error(const std::string& name, const StepReport& report, double time) {
  return {error_kind(report.failure), "body '" + name + "': " + failure_message(report, time)};
}

Result<RecordedMotion> film(const Filmed& filmed, const FrameRange& range, const FrameSteps& frames,
                            double duration) {
  Recording recording(range.rate);
  ToldProgress progress(filmed.name, duration);
  for (const std::int64_t step : frames.steps) {
    if (Status s = filmed.step_to(step); !s) return s.error();
    const double time = filmed.time();
    if (Status s = recording.begin_frame(time); !s) return s.error();
    if (Status s = filmed.record(recording); !s) return s.error();
    progress.reached(time);
  }
  RecordedMotion motion;
  motion.offset = frames.offset;
  motion.even_step = frames.even_step;
  if (Status s = take(motion.animation, recording.animation()); !s) return s.error();
  widen_planes(motion.animation);
  return motion;
}

Result<RecordedMotion> animate_bodies(const std::vector<BodyScene>& bodies,
                                      const FrameRange& range) {
  if (Status s = check_together(bodies); !s) return s.error();
  const Scene& first = bodies.front().file.scene;
  const Result<FrameSteps> frames = frame_steps(range, first.step, first.duration);
  if (!frames) return frames.error();
  std::vector<RunInput> inputs(bodies.size());  // they outlive the worlds
  std::vector<SceneWorld> worlds;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (Status s = take(inputs[i], prepare_run(bodies[i])); !s) return s.error();
    Result<SceneWorld> world = world_of_one(inputs[i]);
    if (!world) return world.error();
    worlds.push_back(std::move(*world));
  }
  std::vector<std::size_t> tracks;  // of the bodies, added in the first frame
  Filmed filmed;
  filmed.name = first.bodies.front().name;
  filmed.time = [&] { return worlds.front().time(); };
  filmed.step_to = [&](std::int64_t step) -> Status {
    for (SceneWorld& world : worlds)
      while (world.steps() < step)
        for (const auto& [body, report] : world.step())
          return step_error(world.name(body), report, world.body(body).time());
    return Success{};
  };
  filmed.record = [&](Recording& recording) -> Status {
    for (std::size_t w = 0; w < worlds.size(); ++w) {
      const Body& body = worlds[w].body(0);
      if (tracks.size() == w) {
        std::string name = worlds[w].name(0);
        while (recording.has_name(name)) name += "-2";
        if (Status s = take(tracks.emplace_back(), recording.add(body, name)); !s) return s;
      }
      if (Status s = recording.record(tracks[w], body); !s) return s;
    }
    return Success{};
  };
  return film(filmed, range, *frames, first.duration);
}

}  // namespace tremolo
