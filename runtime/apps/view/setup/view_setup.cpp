#include "runtime/apps/view/setup/view_setup.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/view/draw/gl_objects.h"
#include "runtime/apps/view/picture/picture_series.h"
#include "runtime/apps/view/setup/viewer_options.h"

namespace tremolo {
namespace {

// sRGB; bodies use them in turn.
constexpr std::array<std::uint32_t, 8> kBodyColours = {0xb06a34, 0x3a7f9a, 0xa83e36, 0x6f8f45,
                                                       0x84609c, 0xc79a36, 0x45907f, 0x9c6474};
constexpr double kDegree = std::numbers::pi / 180.0;
// A good view of the sample models: from the right and above.
constexpr CameraWish kUsualCamera{22.0 * kDegree, 17.0 * kDegree, 1.0};

Result<UpAxis> up_of(const std::string& text, const Scene& scene) {
  if (text == "y") return UpAxis::kY;
  if (text == "z") return UpAxis::kZ;
  if (text != "auto") return usage_error("--up " + text + ": must be y, z or auto");
  const Eigen::Vector3d gravity = scene.gravity.at(0.0);
  return std::abs(gravity[1]) > std::abs(gravity[2]) ? UpAxis::kY : UpAxis::kZ;
}

// "#rrggbb"; none for any other text.
std::optional<Eigen::Vector3f> parse_colour(const std::string& text) {
  std::uint32_t rgb = 0;
  const char* end = text.data() + text.size();
  if (text.size() != 7 || text.front() != '#') return std::nullopt;
  const auto [stop, error] = std::from_chars(text.data() + 1, end, rgb, 16);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return linear_colour(rgb);
}

Result<std::optional<Eigen::Vector3f>> background_of(const std::string& text) {
  if (text == "studio") return std::optional<Eigen::Vector3f>();
  const std::optional<Eigen::Vector3f> colour = parse_colour(text == "white" ? "#ffffff" : text);
  if (!colour) return usage_error("--background " + text + ": must be studio, white or #rrggbb");
  return colour;
}

// Later texts win. A name is a body's, or one of copies without its number.
Result<std::vector<Eigen::Vector3f>> paints_of(const std::vector<std::string>& texts,
                                               const Scene& scene) {
  std::vector<Eigen::Vector3f> paints;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    paints.push_back(linear_colour(kBodyColours[i % kBodyColours.size()]));
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const std::string name = equals == std::string::npos ? "" : text.substr(0, equals);
    const std::optional<Eigen::Vector3f> colour =
        parse_colour(equals == std::string::npos ? text : text.substr(equals + 1));
    if (!colour) return usage_error("--paint " + text + ": expected [BODY=]#rrggbb");
    bool used = false;
    for (std::size_t i = 0; i < paints.size(); ++i) {
      const std::string& body = scene.bodies[i].name;
      if (!name.empty() && body != name && !body.starts_with(name + "-")) continue;
      paints[i] = *colour;
      used = true;
    }
    if (!used) return content_error("--paint " + text + ": there is no body of that name");
  }
  return paints;
}

Result<std::vector<StageImage>> images_of(const std::vector<std::string>& texts) {
  std::vector<StageImage> images;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    StageImage image;
    if (equals != std::string::npos) image.material = text.substr(0, equals);
    const std::string file = equals == std::string::npos ? text : text.substr(equals + 1);
    if (Status s = take(image.picture, read_png(file)); !s) return s.error();
    images.push_back(std::move(image));
  }
  return images;
}

Error no_stress() {
  return {
      ErrorKind::kContent,
      "--colour stress: no body's material is known: a model's file must name one isotropic "
      "material, and its body must not be on bones; tetrahedra must have an isotropic material; "
      "rigid bodies and cloths have no stress"};
}

// A body on bones has none: its shape does not depend on strain alone.
Result<std::vector<std::optional<Material>>> solids_of(const Scene& scene, bool needed,
                                                       bool known) {
  std::vector<std::optional<Material>> solids;
  for (const SceneBody& body : scene.bodies) {
    solids.push_back(body.bones.empty() ? material_of_model(body.model) : std::nullopt);
    known = known || solids.back().has_value();
  }
  if (needed && !known) return no_stress();
  return solids;
}

// step: of the scene, s.
Status check_numbers(const ViewerOptions& options, double step) {
  if (options.frames < 1 || options.frames > 999999)
    return content_error("--frames must be from 1 to 999999");
  if (!(options.from >= 0.0) || !std::isfinite(options.from))
    return content_error("--from must be finite and not negative (s)");
  if (!(options.rate > 0.0) || !std::isfinite(options.rate))
    return content_error("--rate must be positive and finite (Hz)");
  constexpr double kMostSteps = 1e12;
  const double last = options.from + (options.frames - 1) / options.rate;
  if (options.offscreen && !(last / step <= kMostSteps))
    return content_error(
        "--from, --frames and --rate ask for more than 1e12 steps before the last picture");
  if (options.lights != 0 && (options.lights < 2 || options.lights > kMostLights))
    return content_error("--lights must be from 2 to " + std::to_string(kMostLights));
  if (!(options.moved_full >= 0.0) || !std::isfinite(options.moved_full))
    return content_error("--moved-full must be positive and finite (m)");
  if (!(options.slow >= 1e-4 && options.slow <= 1e4))
    return content_error("--slow must be from 0.0001 to 10000");
  if (!(options.duration >= 0.0) || !std::isfinite(options.duration))
    return content_error("--seconds must be finite and not negative");
  if (!(options.stress_full >= 0.0) || !std::isfinite(options.stress_full))
    return content_error("--stress-full must be positive and finite (Pa)");
  constexpr std::string_view kColours[] = {"body", "moved", "stress", "degree"};
  if (std::ranges::find(kColours, options.colour) == std::end(kColours))
    return usage_error("--colour " + options.colour + ": must be body, moved, stress or degree");
  return Success{};
}

}  // namespace

Result<ViewSetup> make_setup(const ViewerOptions& options, const Scene& scene, bool knows_stress) {
  ViewSetup setup;
  if (Status s = check_numbers(options, scene.step); !s) return s.error();
  if (Status s = take(setup.size, parse_size(options.size)); !s) return s.error();
  if (Status s = take(setup.up, up_of(options.up, scene)); !s) return s.error();
  setup.camera = kUsualCamera;
  if (!options.camera.empty())
    if (Status s = take(setup.camera, parse_camera(options.camera)); !s) return s.error();
  const Result<std::optional<Eigen::Vector3f>> background = background_of(options.background);
  if (!background) return background.error();
  setup.background = *background;
  if (Status s = take(setup.paints, paints_of(options.paints, scene)); !s) return s.error();
  if (Status s = take(setup.images, images_of(options.textures)); !s) return s.error();
  if (Status s = take(setup.solids, solids_of(scene, options.colour == "stress", knows_stress)); !s)
    return s.error();
  return setup;
}

ColourBy colour_by(const std::string& name) {
  return name == "moved"    ? ColourBy::kMoved
         : name == "stress" ? ColourBy::kStress
         : name == "degree" ? ColourBy::kDegree
                            : ColourBy::kBody;
}

Status check_stage(const ViewerOptions& options, const Stage& stage) {
  if (options.colour == "stress" && !stage.knows_stress()) return no_stress();
  std::string names;
  for (const std::string& name : stage.without_image()) names += (names.empty() ? "" : ", ") + name;
  if (!names.empty())
    tell("--texture: these bodies have no texture coordinates and keep their colour: {}\n", names);
  return Success{};
}

Camera first_camera(const ViewSetup& setup, const Stage& stage) {
  Camera camera;
  camera.up = setup.up;
  camera.azimuth = setup.camera.azimuth;
  camera.elevation = setup.camera.elevation;
  frame_points(stage.points(), setup.size.aspect(), camera);
  camera.distance /= setup.camera.zoom;
  return camera;
}

LightCounts light_counts(int lights, int side) {
  const int lamps = std::max(1, lights / 4);
  return {lamps, lights - lamps, side};
}

PictureLook look_of(const ViewerOptions& options, const ViewSetup& setup, double ground,
                    bool has_ground, const LightCounts& lights) {
  PictureLook look;
  look.lights = options.lights > 0 ? light_counts(options.lights, lights.side) : lights;
  look.light_azimuth = setup.camera.azimuth;
  look.wire = options.wire;
  look.background = setup.background;
  look.ground = ground;
  look.has_ground = has_ground;
  return look;
}

bool is_scene_of(SceneKind kind, const std::string& file) {
  if (!file.ends_with(".toml")) return false;
  const Result<std::string> text = read_whole_file(file);
  if (!text) return false;
  const Result<SceneKind> found = scene_kind(*text, file);
  return found && *found == kind;
}

int end_view(const Result<int>& code) {
  if (!code) return report_error(code.error());
  const int printed = flushed(*code);
  if (*code > 128) ::raise(*code - 128);
  return printed;
}

std::vector<NamedFile> inputs_of_view(const ViewerOptions& options,
                                      std::vector<NamedFile> of_scene) {
  std::vector<NamedFile> inputs = std::move(of_scene);
  for (const std::string& text : options.textures)
    inputs.push_back({text.substr(text.find('=') + 1), "--texture"});
  return inputs;
}

Status check_view_outputs(const ViewerOptions& options, const std::vector<NamedFile>& inputs) {
  if (options.offscreen && !options.record_hand.empty())
    return usage_error("--record-hand applies only to a window, not to --offscreen");
  std::vector<std::string> outputs = {options.video, options.record_hand};
  if (!options.out.empty())
    for (std::string& path : files_like(options.out, is_picture_name))
      outputs.push_back(std::move(path));
  if (Status s = keep_apart(outputs, inputs); !s) return s;
  if (Status s = check_writable({options.video, options.record_hand}); !s) return s;
  if (options.out.empty()) return Success{};
  return check_writable({(std::filesystem::path(options.out) / picture_name(0)).string()}, true);
}

}  // namespace tremolo
