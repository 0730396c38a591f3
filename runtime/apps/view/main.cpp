// tremolo-view: see and touch the bodies of a model or a scene; pictures of them without a display.
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include <CLI/CLI.hpp>

#include "formats/file/command_words.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/apps/view/cloth/cloth_scenes.h"
#include "runtime/apps/view/live/mode_orbits.h"
#include "runtime/apps/view/live/viewed_scene.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/tets/tets_scenes.h"

namespace tremolo {
namespace {

void add_picture_flags(CLI::App& app, ViewerOptions& o) {
  app.add_option("--size", o.size, "of pictures or the window, in pixels")->capture_default_str();
  app.add_option("--camera", o.camera,
                 "AZIMUTH,ELEVATION[,ZOOM] in degrees; 0,0 looks along +y, 1 frames the bodies");
  app.add_option("--up", o.up, "y, z or auto: against the scene's gravity, else z")
      ->capture_default_str();
  app.add_flag("--follow", o.follow, "the camera goes where the bodies' middle goes");
  app.add_option("--background", o.background, "studio, white or #rrggbb (without a ground)")
      ->capture_default_str();
  app.add_option(
         "--colour", o.colour,
         "body; moved: by how far a vertex is from its rest; stress: by von Mises' stress; degree: "
         "of bodies of tetrahedra, red where all edges are quadratic")
      ->capture_default_str();
  app.add_option("--moved-full", o.moved_full, "m that are red; 0: the largest seen so far");
  app.add_option("--stress-full", o.stress_full, "Pa that are red; 0: the largest seen so far");
  app.add_option("--paint", o.paints, "[BODY=]#rrggbb: a body's colour; may be repeated");
  app.add_option("--texture", o.textures,
                 "[MATERIAL=]FILE.png for bodies with texture coordinates; may be repeated");
  app.add_option("--beside", o.beside, "of cloth: a second scene, shown beside the first");
  app.add_option("--orbit", o.orbit,
                 "MODE:AMPLITUDE, as in 1:8% of the size: a body's periodic motion of this mode "
                 "in place of its own");
  app.add_flag("--wire", o.wire, "show the triangles");
  app.add_flag("--no-colliders", o.no_colliders, "do not show colliders, except the ground");
  app.add_option("--lights", o.lights,
                 "directions that light comes from, 2 to 96: softer shadows, slower");
}

void add_offscreen_flags(CLI::App& app, ViewerOptions& o) {
  app.add_flag("--offscreen", o.offscreen, "pictures without a display");
  app.add_option("--frames", o.frames, "how many")->capture_default_str();
  app.add_option("--from", o.from, "simulated time of the first, s")->capture_default_str();
  app.add_option("--rate", o.rate, "pictures a simulated second; of a film, a second")
      ->capture_default_str();
  app.add_option("--out", o.out, "a folder: frame-000000.png ...");
  app.add_option("--video", o.video, "a film, .mp4 or .webm (needs ffmpeg)");
  app.add_flag("--json", o.json, "print one JSON object on stdout");
}

void add_window_flags(CLI::App& app, ViewerOptions& o) {
  app.add_option("--slow", o.slow, "simulated time a real time: 0.1 is ten times slower")
      ->capture_default_str();
  app.add_flag("--paused", o.paused, "begin paused");
  app.add_option("--record-hand", o.record_hand,
                 "a scene file, written at the end, in which a hand does what the mouse did");
  app.add_option("--seconds", o.duration, "close the window after so long");
  app.add_flag("--measure", o.measure, "tell at the end what pictures and the mouse cost");
}

struct ViewParser {
  CLI::App app{"See and touch the bodies of a model or a scene. SI units."};

  explicit ViewParser(ViewerOptions& options) {
    app.name("tremolo view");
    app.set_version_flag("--version", std::string("tremolo ") + TREMOLO_VERSION);
    app.add_option("file", options.file, "basis file, or scene.toml")->required();
    add_picture_flags(app, options);
    add_offscreen_flags(app, options);
    add_window_flags(app, options);
    add_body_flags(app, options.body);
    add_modes_flag(app, options.body);
  }
};

// True if a flag applies to scenes and was given. Some flags of `tremolo run` have another meaning
// here.
bool is_given(const CLI::App& app, const std::string& flag) {
  static const std::set<std::string> kOwn = {"--out", "--surfaces", "--every", "--plot"};
  const CLI::Option* option = app.get_option_no_throw(flag);
  return !kOwn.contains(flag) && option != nullptr && option->count() > 0;
}

int view(int count, char** words) {
  // Also started as `tremolo view ...`, which hands over all of its words.
  if (count > 1 && std::strcmp(words[1], "view") == 0) {
    --count;
    ++words;
  }
  ViewerOptions options;
  ViewParser parser(options);
  if (const std::optional<int> code = read_words(parser.app, count, words)) return *code;
  const GivenFlags flags{options.body,
                         [&parser](const char* flag) { return is_given(parser.app, flag); }};
  if (!options.orbit.empty()) {
    if (const auto orbit = parse_orbit_request(options.orbit); !orbit)
      return report_error(orbit.error());
    if (is_scene_of(SceneKind::kCloth, options.file) || is_scene_of(SceneKind::kTets, options.file))
      return report_error(usage_error("--orbit applies only to a body with a basis file"));
  }
  if (is_scene_of(SceneKind::kCloth, options.file)) return view_cloth_command(options, flags);
  if (!options.beside.empty())
    return report_error(usage_error("--beside applies only to scenes of cloth"));
  if (is_scene_of(SceneKind::kTets, options.file)) return view_tets_command(options, flags);
  const Result<ViewedScene> viewed = read_viewed_scene(options.file, flags);
  if (!viewed) return report_error(viewed.error());
  if (options.colour == "degree" && viewed->tets.empty())
    return report_error(
        usage_error("--colour degree applies only to bodies of kind \"tets\": there are none"));
  const std::vector<NamedFile> inputs = inputs_of_view(options, viewed->inputs);
  if (Status s = check_view_outputs(options, inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  return options.offscreen ? offscreen_command(options, *viewed) : window_command(options, *viewed);
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  return tremolo::run_guarded([&] { return tremolo::view(count, words); });
}
