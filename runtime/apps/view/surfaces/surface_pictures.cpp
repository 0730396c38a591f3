#include <memory>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/view/offscreen/egl_context.h"
#include "runtime/apps/view/picture/picture_series.h"
#include "runtime/apps/view/setup/frame_times.h"
#include "runtime/apps/view/surfaces/surface_stage.h"
#include "runtime/apps/view/surfaces/surface_window.h"

namespace tremolo {
namespace {

constexpr LightCounts kSurfaceLights{12, 36, 1024};

// The drawing objects; the context must be destroyed last.
struct SurfaceStudio {
  std::unique_ptr<EglContext> context;
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<SurfaceStage> stage;
  std::optional<PictureTarget> target;
};

Result<SurfaceStudio> open_surface_studio(const ViewerOptions& options, const ViewSetup& setup,
                                          const MovingSurfaces& scenes) {
  SurfaceStudio studio;
  if (Status s = take(studio.context, EglContext::create()); !s) return s.error();
  if (Status s = take(studio.renderer, Renderer::create()); !s) return s.error();
  if (Status s = take(studio.stage, SurfaceStage::create(scenes, setup, options)); !s)
    return s.error();
  Result<PictureTarget> target = PictureTarget::create(setup.size);
  if (!target) return target.error();
  studio.target.emplace(std::move(*target));
  return studio;
}

struct SurfaceShots {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  FrameTimes times;
  int signal = 0;
};

Status shoot_all(const ViewerOptions& options, const ViewSetup& setup, MovingSurfaces& scenes,
                 SurfaceStudio& studio, PictureSeries& series, SurfaceShots& shots) {
  const Interruption interruption;
  SurfaceStage& stage = *studio.stage;
  Camera camera;
  Picture picture;
  for (int k = 0; k < options.frames && shots.signal == 0; ++k) {
    const double due = options.from + k / options.rate;
    while (scenes.time() < due - 1e-9 * scenes.step_size() && interruption.signal() == 0)
      if (Status s = scenes.step(); !s) return s;
    shots.signal = interruption.signal();
    if (shots.signal != 0) break;
    shots.times.begin();
    stage.pose(scenes);
    PictureLook look = look_of(options, setup, stage, kSurfaceLights);
    if (k == 0) camera = camera_of_points(setup, stage.points());
    shots.times.prepared();
    stage.upload();
    look.full = stage.full();
    if (Status s = studio.renderer->draw(stage.things(), stage.ball(), camera, setup.size, look,
                                         studio.target->framebuffer());
        !s)
      return s;
    studio.target->read(picture);
    shots.times.drawn();
    if (Status s = series.add(picture); !s) return s;
    nlohmann::ordered_json frame{{"time", scenes.time()}};
    if (!options.out.empty()) frame["file"] = series.files().back();
    shots.frames.push_back(std::move(frame));
    shots.signal = interruption.signal();
  }
  return Success{};
}

}  // namespace

Scene names_of(const MovingSurfaces& scenes) {
  Scene names;
  names.gravity = scenes.gravity();
  names.step = scenes.step_size();
  for (const ShownSheet& sheet : scenes.sheets()) names.bodies.emplace_back().name = sheet.name;
  for (const ShownSolid& solid : scenes.solids())
    if (solid.collider == nullptr) names.bodies.emplace_back().name = solid.name;
  return names;
}

bool has_materials(const MovingSurfaces& scenes) {
  for (const ShownSheet& sheet : scenes.sheets())
    for (const std::optional<Material>& material : sheet.materials)
      if (material) return true;
  return false;
}

Camera camera_of_points(const ViewSetup& setup, const std::vector<double>& points) {
  Camera camera;
  camera.up = setup.up;
  camera.azimuth = setup.camera.azimuth;
  camera.elevation = setup.camera.elevation;
  frame_points(points, setup.size.aspect(), camera);
  camera.distance /= setup.camera.zoom;
  return camera;
}

Result<int> photograph_surfaces(const ViewerOptions& options, MovingSurfaces& scenes) {
  if (options.out.empty() && options.video.empty())
    return usage_error("--offscreen needs --out DIR, --video FILE.mp4|.webm, or both");
  const Result<ViewSetup> setup = make_setup(options, names_of(scenes), has_materials(scenes));
  if (!setup) return setup.error();
  Result<SurfaceStudio> studio = open_surface_studio(options, *setup, scenes);
  if (!studio) return studio.error();
  Result<PictureSeries> series = PictureSeries::create(options.out, options.video, options.rate,
                                                       setup->size.width, setup->size.height);
  if (!series) return series.error();
  SurfaceShots shots;
  if (Status s = shoot_all(options, *setup, scenes, *studio, *series, shots); !s) return s.error();
  if (Status s = series->finish(); !s) return s.error();
  const int code = shots.signal != 0 ? 128 + shots.signal : 0;
  tell("{}: {} pictures of {}x{}, {:.1f} ms each to pose them and {:.0f} ms to draw{}\n",
       options.file, shots.frames.size(), setup->size.width, setup->size.height,
       shots.times.prepare_ms(), shots.times.draw_ms(),
       studio->renderer->is_software() ? " (by software)" : "");
  if (!options.json) return code;
  const nlohmann::ordered_json json{
      {"file", options.file},
      {"width", setup->size.width},
      {"height", setup->size.height},
      {"prepare_ms", shots.times.prepare_ms()},
      {"draw_ms", shots.times.draw_ms()},
      {"software", studio->renderer->is_software()},
      {"steps", scenes.steps()},
      {"largest_stress", options.colour == "stress"
                             ? nlohmann::ordered_json(studio->stage->most_stressed())
                             : nlohmann::ordered_json()},
      {"frames", shots.frames},
      {"exit_code", code}};
  print_json(json);
  return code;
}

}  // namespace tremolo
