#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/view/draw/renderer.h"
#include "runtime/apps/view/live/live_world.h"
#include "runtime/apps/view/live/mode_orbits.h"
#include "runtime/apps/view/offscreen/egl_context.h"
#include "runtime/apps/view/picture/picture_series.h"
#include "runtime/apps/view/setup/frame_times.h"
#include "runtime/apps/view/setup/view_setup.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/response/orbit.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr LightCounts kOffscreenLights{12, 36, 1024};

struct ShotList {
  Json frames = Json::array();
  Camera camera;
  FrameTimes times;
  int signal = 0;
  float most_stressed = 0.0f;  // Pa
};

// The drawing objects; the context must be destroyed last.
struct Studio {
  std::unique_ptr<EglContext> context;
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<Stage> stage;
  std::optional<PictureTarget> target;
};

Result<Studio> open_studio(const ViewerOptions& options, const ViewSetup& setup,
                           const LiveWorld& live) {
  Studio studio;
  if (Status s = take(studio.context, EglContext::create()); !s) return s.error();
  if (Status s = take(studio.renderer, Renderer::create()); !s) return s.error();
  if (Status s = take(studio.stage,
                      Stage::create(live, setup.up, setup.paints, setup.images, setup.solids));
      !s)
    return s.error();
  if (Status s = check_stage(options, *studio.stage); !s) return s.error();
  Result<PictureTarget> target = PictureTarget::create(setup.size);
  if (!target) return target.error();
  studio.target.emplace(std::move(*target));
  return studio;
}

class Photographer {
 public:
  Photographer(const ViewerOptions& options, const ViewSetup& setup, LiveWorld& live,
               Studio& studio)
      : options_(options), setup_(setup), live_(live), studio_(studio) {
    look_ = look_of(options, setup, *studio.stage, kOffscreenLights);
    stage_look_ = {colour_by(options.colour), !options.no_colliders};
  }

  std::optional<CurvePoint> orbit;  // shown in place of the body's own motion

  Status run(PictureSeries& series, ShotList& shots) {
    const Interruption interruption;
    Picture picture;
    for (int k = 0; k < options_.frames && shots.signal == 0; ++k) {
      const double t = options_.from + k / options_.rate;
      if (Status s = go_to(t, interruption); !s) return s;
      shots.signal = interruption.signal();
      if (shots.signal != 0) break;
      if (k == 0) shots.camera = first_camera_at(t);
      if (Status s = shoot(t, shots, picture); !s) return s;
      if (Status s = series.add(picture); !s) return s;
      Json frame{{"time", moment_.time}};
      if (!options_.out.empty()) frame["file"] = series.files().back();
      shots.frames.push_back(std::move(frame));
      shots.signal = interruption.signal();
    }
    return Success{};
  }

 private:
  // The state at t, or the orbit's.
  void pose_at(double t) {
    live_.at(t, moment_);
    if (orbit) {
      moment_.time = t;
      moment_.bodies[0].q = orbit_state(*orbit, orbit->omega * t).q;
    }
    studio_.stage->pose(moment_);
  }

  // Steps to t unless a signal arrives.
  Status go_to(double t, const Interruption& interruption) {
    // Within a billionth of a step of a node it is that node.
    if (orbit) return Success{};
    const double slack = 1e-9 * live_.world().step_size();
    while (live_.now().time < t - slack && interruption.signal() == 0)
      if (Status s = live_.step(); !s) return s;
    return Success{};
  }

  Camera first_camera_at(double t) {
    pose_at(t);
    return first_camera(setup_, *studio_.stage);
  }

  // The value shown in red: the requested one, or the largest so far.
  float full_colour(const Stage& stage, ShotList& shots) {
    if (stage_look_.colour == ColourBy::kDegree) return 1.0f;
    moved_ = std::max(moved_, stage.most_moved());
    const bool stress = stage_look_.colour == ColourBy::kStress;
    shots.most_stressed = std::max(shots.most_stressed, stage.most_stressed());
    const double asked = stress ? options_.stress_full : options_.moved_full;
    return asked > 0.0 ? static_cast<float>(asked) : stress ? shots.most_stressed : moved_;
  }

  Status shoot(double t, ShotList& shots, Picture& picture) {
    shots.times.begin();
    pose_at(t);
    Stage& stage = *studio_.stage;
    if (options_.follow) follow(shots.camera);
    look_.ground = stage.ground();
    shots.times.prepared();
    stage.upload(stage_look_);
    look_.full = full_colour(stage, shots);
    if (Status s =
            studio_.renderer->draw(stage.things(stage_look_, eye_of(shots.camera)), stage.ball(),
                                   shots.camera, setup_.size, look_, studio_.target->framebuffer());
        !s)
      return s;
    studio_.target->read(picture);
    shots.times.drawn();
    return Success{};
  }

  // Moves the target with the middle of the bodies.
  void follow(Camera& camera) {
    const std::vector<double> points = studio_.stage->points();
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i + 2 < points.size(); i += 3)
      middle += Eigen::Vector3d(points[i], points[i + 1], points[i + 2]);
    middle *= 3.0 / static_cast<double>(std::max<std::size_t>(3, points.size()));
    if (middle_) camera.target += middle - *middle_;
    middle_ = middle;
  }

  const ViewerOptions& options_;
  const ViewSetup& setup_;
  LiveWorld& live_;
  Studio& studio_;
  PictureLook look_;
  StageLook stage_look_;
  WorldMoment moment_;
  float moved_ = 0.0f;  // m, the largest so far
  std::optional<Eigen::Vector3d> middle_;
};

Json three(const Eigen::Vector3d& v) {
  return Json::array({v[0], v[1], v[2]});
}

Json json_of(const ViewerOptions& options, const ViewSetup& setup, const ShotList& shots,
             const LiveWorld& live, const std::optional<CurvePoint>& orbit, bool software) {
  const Camera& camera = shots.camera;
  Json json;
  json["file"] = options.file;
  json["width"] = setup.size.width;
  json["height"] = setup.size.height;
  json["camera"] = {{"eye", three(eye_of(camera))},
                    {"target", three(camera.target)},
                    {"up", three(axes_of(camera).up)},
                    {"view_angle", camera.view_angle}};
  json["prepare_ms"] = shots.times.prepare_ms();
  json["draw_ms"] = shots.times.draw_ms();
  json["software"] = software;
  json["steps"] = live.world().steps();
  json["largest_stress"] = options.colour == "stress" ? Json(shots.most_stressed) : Json(nullptr);
  if (orbit)
    json["orbit"] = {{"frequency_hz", orbit->omega / (2.0 * std::numbers::pi)},
                     {"amplitude", orbit->amplitude}};
  json["frames"] = shots.frames;
  json["video"] = options.video.empty() ? Json(nullptr) : Json(options.video);
  json["reason"] = live.trouble().empty() ? Json(nullptr) : Json(live.trouble());
  json["exit_code"] = shots.signal != 0 ? 128 + shots.signal : live.trouble_code();
  return json;
}

// The motion of --orbit. Errors: check_orbit_world's and mode_orbits'; kSolver if the backbone ends
// before the amplitude.
Result<CurvePoint> orbit_of(const ViewerOptions& options, const SceneWorld& world) {
  if (Status s = check_orbit_world(world); !s) return s.error();
  const Result<OrbitRequest> request = parse_orbit_request(options.orbit);
  if (!request) return request.error();
  const Result<ModeOrbits> orbits = mode_orbits(world.body(0).model(), request->mode);
  if (!orbits) return Error{orbits.error().kind, "--orbit: " + orbits.error().message};
  if (request->share > orbits->largest() * (1.0 + 1e-9))
    return Error{ErrorKind::kSolver,
                 fmt::format("--orbit {}: the orbits of this mode were found up to {:.3g} % of the "
                             "size only",
                             options.orbit, 100.0 * orbits->largest())};
  return orbits->at(request->share);
}

Result<int> photograph(const ViewerOptions& options, const ViewedScene& viewed) {
  if (options.out.empty() && options.video.empty())
    return usage_error("--offscreen needs --out DIR, --video FILE.mp4|.webm, or both");
  const Result<ViewSetup> setup = make_setup(options, shown_scene(viewed), !viewed.tets.empty());
  if (!setup) return setup.error();
  ModelCache models;
  Result<LiveWorld> live = LiveWorld::create(viewed, models);
  if (!live) return live.error();
  Result<Studio> studio = open_studio(options, *setup, *live);
  if (!studio) return studio.error();
  Result<PictureSeries> series = PictureSeries::create(options.out, options.video, options.rate,
                                                       setup->size.width, setup->size.height);
  if (!series) return series.error();
  ShotList shots;
  Photographer photographer(options, *setup, *live, *studio);
  if (!options.orbit.empty()) {
    Result<CurvePoint> orbit = orbit_of(options, live->world());
    if (!orbit) return orbit.error();
    photographer.orbit = std::move(*orbit);
  }
  if (Status s = photographer.run(*series, shots); !s) return s.error();
  if (Status s = series->finish(); !s) return s.error();
  tell("{}: {} pictures of {}x{}, {:.1f} ms each to pose them and {:.0f} ms to draw{}; {}\n",
       options.file, shots.frames.size(), setup->size.width, setup->size.height,
       shots.times.prepare_ms(), shots.times.draw_ms(),
       studio->renderer->is_software() ? " (by software)" : "",
       series->files().empty() ? "" : series->files().back());
  if (!live->trouble().empty()) tell("tremolo: {}\n", live->trouble());
  if (options.json)
    print_json(json_of(options, *setup, shots, *live, photographer.orbit,
                       studio->renderer->is_software()));
  return shots.signal != 0 ? 128 + shots.signal : live->trouble_code();
}

}  // namespace

int offscreen_command(const ViewerOptions& options, const ViewedScene& viewed) {
  return end_view(photograph(options, viewed));
}

}  // namespace tremolo
