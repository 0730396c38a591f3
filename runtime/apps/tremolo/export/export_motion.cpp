#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/glb_writer.h"
#include "runtime/io/exchange/recording.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

GlbTexture texture_of_flag(const std::string& text) {
  const std::size_t equals = text.find('=');
  // A file may have the sign in its name.
  if (equals == std::string::npos || std::filesystem::exists(text)) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::vector<NamedFile> sources_of(const MotionOutputs& outputs, const MotionSource& source) {
  namespace fs = std::filesystem;
  std::vector<NamedFile> files = source.inputs;
  for (const std::string& text : outputs.textures)
    files.push_back({texture_of_flag(text).path, "--texture"});
  for (const PlotSource& run : plot_sources(outputs.extras.runs)) {
    files.push_back({run.csv, "--runs"});
    files.push_back({(fs::path(run.csv).parent_path() / kReportName).string(), "--runs"});
  }
  // As the page names it, from its own folder.
  if (const std::string& live = outputs.extras.live; !live.empty()) {
    files.push_back({live, "--live"});
    files.push_back({(fs::path(outputs.page).parent_path() / live).string(), "--live"});
  }
  return files;
}

Status check_endings(const MotionOutputs& outputs) {
  for (const auto& [flag, path, ending] : {std::tuple{"--glb", &outputs.glb, ".glb"},
                                           {"--pc2", &outputs.pc2, ".pc2"},
                                           {"--mdd", &outputs.mdd, ".mdd"},
                                           {"--pvd", &outputs.pvd, ".pvd"},
                                           {"--usda", &outputs.usda, ".usda"},
                                           {"--page", &outputs.page, ".html"}})
    if (!path->empty() && !path->ends_with(ending))
      return usage_error(fmt::format("{} {}: the name must end in {}", flag, *path, ending));
  const std::string& series = outputs.series;
  if (!series.empty() && !series.ends_with(".ply") && !series.ends_with(".obj"))
    return usage_error("--series " + series + ": the name must end in .ply or .obj");
  if (outputs.page.empty() && outputs.extras.any())
    return usage_error("--runs, --note and --live apply only to --page");
  return Success{};
}

// Refuses bodies whose names give the same file name.
Status check_names(const MotionOutputs& outputs, const MotionSource& source) {
  if (outputs.pc2.empty() && outputs.mdd.empty() && outputs.pvd.empty() && outputs.series.empty())
    return Success{};
  std::vector<std::string> names = source.names;
  const std::vector<std::string> scenery = source.scenery;
  if (!outputs.pvd.empty() && !outputs.no_colliders)
    names.insert(names.end(), scenery.begin(), scenery.end());
  std::map<std::string, std::string> taken;
  for (const std::string& name : names) {
    const auto [other, is_new] = taken.try_emplace(file_name_of(name), name);
    // Scenery with the name of a body gets another one.
    if (!is_new && other->second != name)
      return usage_error("bodies '" + other->second + "' and '" + name +
                         "' would be written into the same files");
  }
  return Success{};
}

// The files that are requested by name, and those next to point caches. numbered: files that a
// series may overwrite or remove.
struct MotionPaths {
  std::vector<std::string> named, numbered;
};

MotionPaths paths_of(const MotionOutputs& outputs, const MotionSource& source) {
  MotionPaths paths;
  paths.named = {outputs.glb, outputs.pvd, outputs.usda, outputs.page};
  const std::vector<std::string> names = source.names;
  std::vector<std::string> shapes;
  for (const std::string& name : names)
    for (const auto& [cache, ending] : {std::pair{&outputs.pc2, ".pc2"}, {&outputs.mdd, ".mdd"}}) {
      if (cache->empty()) continue;
      const std::string stem =
          without_ending(*cache) + (names.size() < 2 ? "" : "-" + file_name_of(name));
      paths.named.push_back(stem + ending);
      shapes.push_back(stem + ".obj");
    }
  // Two caches of one name share their rest shape.
  std::sort(shapes.begin(), shapes.end());
  shapes.erase(std::unique(shapes.begin(), shapes.end()), shapes.end());
  paths.named.insert(paths.named.end(), shapes.begin(), shapes.end());
  if (!outputs.series.empty()) {
    paths.named.push_back(list_of_series(outputs.series));
    paths.numbered = files_of_series(outputs.series);
  }
  if (!outputs.pvd.empty())
    for (std::string& file : files_of_pvd(outputs.pvd)) paths.numbered.push_back(std::move(file));
  return paths;
}

// All of it is checked before the run: names, inputs, and whether files can be written.
Status check_paths(const MotionOutputs& outputs, const std::vector<NamedFile>& sources,
                   const MotionSource& source) {
  if (Status s = check_endings(outputs); !s) return s;
  if (!outputs.textures.empty() && outputs.glb.empty())
    return usage_error("--texture applies only to --glb: no other requested format has images");
  if (Status s = check_names(outputs, source); !s) return s;
  const MotionPaths paths = paths_of(outputs, source);
  std::vector<std::string> all = paths.named;
  all.insert(all.end(), paths.numbered.begin(), paths.numbered.end());
  if (Status s = keep_apart(all, sources); !s) return s;
  if (Status s = check_writable(paths.named); !s) return s;
  if (!outputs.series.empty())
    if (Status s = check_writable({without_ending(outputs.series) + "-0000.ply"}); !s) return s;
  if (outputs.pvd.empty()) return Success{};
  return check_writable({folder_of_pvd(outputs.pvd) + "/0.vtu"}, true);
}

Json file_json(const WrittenFile& file, const char* format) {
  return {{"file", file.path}, {"format", format}, {"bytes", file.bytes}};
}

Result<Json> write_as_glb(const MotionOutputs& outputs, const Animation& animation) {
  GlbOptions options;
  options.plain = outputs.plain_weights;
  options.normals = !outputs.no_normals;
  options.normal_targets = outputs.normal_targets;
  options.z_up = outputs.up == "z";
  for (const std::string& text : outputs.textures)
    options.textures.push_back(texture_of_flag(text));
  const Result<GlbReport> report = write_glb(outputs.glb, animation, options);
  if (!report) return report.error();
  Json json = file_json({outputs.glb, report->bytes}, "glb");
  json["vertices"] = report->vertices;
  json["targets"] = report->targets;
  json["normal_targets"] = report->normal_targets;
  json["dropped"] = report->dropped;
  json["position_error"] = report->position_error;
  json["normal_error_mean"] = report->normal_mean;
  json["normal_error_max"] = report->normal_max;
  if (report->bones_a_vertex > 0) {
    json["bones_a_vertex"] = report->bones_a_vertex;
    json["four_bones_error"] = report->four_bones_error;
  }
  return json;
}

void append_files(Json& files, const std::vector<WrittenFile>& written, const char* format) {
  for (const WrittenFile& file : written) {
    const bool beside = file.path.ends_with(".obj") && std::string_view(format) != "series";
    const Json entry = file_json(file, beside ? "obj" : format);
    // The rest shape of two caches of one name is one file.
    if (std::find(files.begin(), files.end(), entry) == files.end()) files.push_back(entry);
  }
}

Result<Json> write_as_page(const MotionOutputs& outputs, const Animation& animation,
                           const std::string& subtitle) {
  const Result<PageReport> report =
      write_page_report(outputs.page, animation, outputs.extras, subtitle, outputs.up == "z");
  if (!report) return report.error();
  Json json = file_json({outputs.page, report->bytes}, "page");
  json["position_error"] = report->position_error;
  return json;
}

// Writes page and glb, which need few numbers per frame: a motion without modes gets the modes of
// its recording.
Status write_by_modes(const MotionOutputs& outputs, const Animation& recorded,
                      const std::string& subtitle, Json& files) {
  if (outputs.page.empty() && outputs.glb.empty()) return Success{};
  const bool free =
      std::any_of(recorded.bodies.begin(), recorded.bodies.end(),
                  [](const AnimatedBody& body) { return !body.displacements.empty(); });
  Animation described;
  double error = 0.0;
  if (free) {
    described = recorded;
    if (Status s = take(error, describe_by_modes(described)); !s) return s;
  }
  const Animation& animation = free ? described : recorded;
  const auto add = [&](Result<Json> json) -> Status {
    if (!json) return json.error();
    if (free) {
      (*json)["recorded_modes"] = animation.shapes.front().modes.cols();
      (*json)["recorded_modes_error"] = error;
    }
    files.push_back(std::move(*json));
    return Success{};
  };
  if (!outputs.page.empty())
    if (Status s = add(write_as_page(outputs, animation, subtitle)); !s) return s;
  if (outputs.glb.empty()) return Success{};
  return add(write_as_glb(outputs, animation));
}

Result<Json> write_motion_files(const MotionOutputs& outputs, const Animation& animation,
                                const std::string& subtitle) {
  Json files = Json::array();
  if (Status s = write_by_modes(outputs, animation, subtitle, files); !s) return s.error();
  if (!outputs.usda.empty()) {
    const Result<WrittenFile> usda = write_usda(outputs.usda, animation, outputs.up == "z");
    if (!usda) return usda.error();
    files.push_back(file_json(*usda, "usda"));
  }
  using Writer = Result<std::vector<WrittenFile>> (*)(const std::string&, const Animation&);
  for (const auto& [path, writer, format] :
       {std::tuple<const std::string&, Writer, const char*>{outputs.pc2, write_point_caches, "pc2"},
        {outputs.mdd, write_point_caches, "mdd"},
        {outputs.pvd, write_pvd, "pvd"},
        {outputs.series, write_surface_series, "series"}}) {
    if (path.empty()) continue;
    const Result<std::vector<WrittenFile>> written = writer(path, animation);
    if (!written) return written.error();
    append_files(files, *written, format);
  }
  return files;
}

// Prints the list of a series instead of its files, and only the first of many point caches.
void print_files(const Json& files) {
  constexpr std::size_t kShown = 24;
  constexpr double kMuchTurned = 10;  // degrees: shading then shows it
  std::size_t shown = 0, passed_over = 0;
  double bytes = 0.0;
  for (const Json& file : files) {
    const std::string path = file["file"], format = file["format"];
    const bool numbered = format == "pvd" || format == "series";
    const bool list = numbered && (path.ends_with(".pvd") || path.ends_with(".csv"));
    if (!list && (numbered || shown >= kShown)) {
      ++passed_over;
      bytes += file["bytes"].get<double>();
      continue;
    }
    ++shown;
    show("{}: {} bytes", path, file["bytes"].get<std::uint64_t>());
    if (format == "glb")
      show(
          ", {} vertices, {} morph targets and {} of normals ({} coordinates never change); "
          "positions to {:.1e} of "
          "the size, normals to {:.2g} degrees in the mean",
          file["vertices"].get<std::size_t>(), file["targets"].get<std::size_t>(),
          file["normal_targets"].get<std::size_t>(), file["dropped"].get<std::size_t>(),
          file["position_error"].get<double>(), file["normal_error_mean"].get<double>());
    if (format == "glb" && file["normal_error_max"].get<double>() > kMuchTurned)
      show(
          "; up to {:.2g} degrees where it bends most: --normal-targets 8 follows it, --no-normals "
          "leaves them to the viewer",
          file["normal_error_max"].get<double>());
    if (format == "page")
      show(", positions to {:.1e} of the size", file["position_error"].get<double>());
    if (file.contains("recorded_modes"))
      show("; {} modes of the recorded motion, to {:.1e} of the size",
           file["recorded_modes"].get<std::int64_t>(), file["recorded_modes_error"].get<double>());
    show("\n");
    if (file.contains("four_bones_error") && file["four_bones_error"] > 0.0)
      show(
          "  up to {} bones carry a vertex: programs that read four of them show some by {:.2g} of "
          "the size elsewhere\n",
          file["bones_a_vertex"].get<std::size_t>(), file["four_bones_error"].get<double>());
  }
  if (passed_over > 0) show("and {} files of {:.3g} MB\n", passed_over, 1e-6 * bytes);
}

void tell_motion(const MotionOutputs& outputs, const RecordedMotion& motion, double left_out) {
  const Animation& animation = motion.animation;
  tell("  {} bodies, {} frames from {:.6g} to {:.6g} s\n", deforming_bodies(animation).size(),
       animation.frames(), animation.times.front(), animation.times.back());
  // Formats that count frames show them at even times.
  if (motion.offset > 1e-9 && !(outputs.pc2.empty() && outputs.series.empty()))
    tell(
        "  frames are whole steps, up to {:.3g} ms beside k/{} s, where PC2 and numbered files "
        "have "
        "them; --step {:.9g} makes them even\n",
        1e3 * motion.offset, outputs.range.rate, motion.even_step);
  if (outputs.modes > 0)
    tell(
        "  the first {} coordinates: what is left out moves no vertex by more than {:.3g} of the "
        "size\n",
        outputs.modes, left_out);
  if (!motion.left_out.empty())
    tell("  without triangles of their own and left out: {}\n", fmt::join(motion.left_out, ", "));
}

Status export_motion(const MotionOutputs& outputs, const MotionSource& source) {
  if (outputs.modes > 0 && !source.no_modes.empty()) return usage_error(source.no_modes);
  if (!outputs.extras.live.empty() && !source.no_live.empty()) return usage_error(source.no_live);
  const std::vector<NamedFile> sources = sources_of(outputs, source);
  if (Status s = check_paths(outputs, sources, source); !s) return s;
  const GuardedInputs guard(sources);
  Result<RecordedMotion> motion = source.record(outputs.range, !outputs.no_colliders);
  if (!motion) return motion.error();
  double left_out = 0.0;
  if (outputs.modes > 0)
    if (Status s = take(left_out, keep_coordinates(motion->animation, outputs.modes)); !s) return s;
  const Result<Json> files = write_motion_files(outputs, motion->animation, source.description);
  if (!files) return files.error();
  tell_motion(outputs, *motion, left_out);
  if (!outputs.json) {
    print_files(*files);
    return Success{};
  }
  Json json;
  json["frames"] = motion->animation.frames();
  json["first"] = motion->animation.times.front();
  json["last"] = motion->animation.times.back();
  json["rate"] = motion->animation.rate;
  json["offset"] = motion->offset;
  json["bodies"] = deforming_bodies(motion->animation).size();
  json["left_out_error"] = outputs.modes > 0 ? Json(left_out) : Json(nullptr);
  json["colliders_left_out"] = motion->left_out;
  json["files"] = *files;
  print_json(json);
  return Success{};
}

}  // namespace

int export_motion_command(const MotionOutputs& outputs, const MotionSource& source) {
  if (Status s = export_motion(outputs, source); !s) return report_error(s.error());
  return flushed(0);
}

}  // namespace tremolo
