#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "common/mesh/selector.h"
#include "common/units.h"
#include "formats/basis/basis_reader.h"
#include "runtime/apps/tremolo/command_line.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/model.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;
namespace layout = basis_layout;

struct Contents {
  std::vector<double> frequencies;  // Hz
  Json provenance;                  // null if the file has none or it is no JSON
  DefaultLoad load;
  std::optional<RenderBlock> render;
};

// Parses the file's provenance, which is untrusted: nesting is limited, since JSON values are
// copied and printed by recursion.
Result<Json> parse_provenance(std::string_view text) {
  constexpr int kDeepest = 64;
  bool deep = false;
  Json json = Json::parse(
      text,
      [&deep](int depth, Json::parse_event_t, Json&) {
        deep = deep || depth > kDeepest;
        return !deep;
      },
      false);
  if (deep) return content_error("section 'provenance' is nested too deep");
  if (json.is_discarded()) return content_error("section 'provenance' is not JSON");
  return json;
}

Result<Contents> read_contents(BasisReader& reader) {
  if (Status status = reader.verify_all(); !status) return status.error();
  Contents contents;
  const Result<Eigen::VectorXd> lambda = read_lambda(reader);
  if (!lambda) return lambda.error();
  for (double value : *lambda) contents.frequencies.push_back(hertz(value));
  if (Status s = take(contents.load, read_default_load(reader)); !s) return s.error();
  if (Status s = take(contents.render, read_render(reader)); !s) return s.error();
  if (!reader.has(layout::kProvenance)) return contents;
  const Result<std::string_view> text = reader.text(layout::kProvenance);
  if (!text) return text.error();
  if (Status s = take(contents.provenance, parse_provenance(*text)); !s) return s.error();
  return contents;
}

// Refuses every file that the runtime would refuse, and also checks the vertices inside.
Status check_model(BasisReader& reader) {
  const Result<BasisData> data = read_basis(reader);
  if (!data) return data.error();
  const Result<Model::Pointer> model = Model::from_data(*data);
  return model ? Status(Success{}) : Status(model.error());
}

double step_limit(const Contents& contents) {
  return 1.0 / (std::numbers::pi * contents.frequencies.back());
}

// With the step that `tremolo run` takes by default.
Warnings warnings_of(const Contents& contents) {
  const std::string step = step_warning(contents.frequencies.front(), RunOptions{}.step,
                                        "with the default step the ", "--step ");
  return step.empty() ? Warnings{} : Warnings{step};
}

Json sections_json(const BasisReader& reader) {
  Json sections = Json::array();
  for (const BasisSection& section : reader.sections())
    sections.push_back({{"name", section.name},
                        {"bytes", section.size},
                        {"rows", section.rows},
                        {"columns", section.columns},
                        {"critical", section.critical}});
  return sections;
}

Json load_json(const DefaultLoad& load) {
  if (load.vertices.empty()) return nullptr;
  Json forces = Json::array();
  for (const Eigen::Vector3d& force : load.forces)
    forces.push_back({force.x(), force.y(), force.z()});
  return {{"vertices", load.vertices}, {"forces_n", forces}};
}

// The encoding and, for a compact file, the errors that its maker found.
Json encoding_json(const BasisReader& reader, const Json& provenance) {
  if (!reader.compact()) return {{"name", "full"}};
  Json encoding{{"name", "compact"}};
  if (provenance.is_object() && provenance.contains("encoding") &&
      provenance["encoding"].is_object())
    encoding.update(provenance["encoding"]);
  return encoding;
}

std::string encoding_text(const Json& encoding) {
  if (encoding["name"] != "compact") return "full: every number f64";
  std::string text = "compact: coefficients f32, basis rows 16 bits";
  const auto add = [&](const char* key, const char* what) {
    if (encoding.contains(key) && encoding[key].is_number())
      text += fmt::format("; {} {:.2g}", what, encoding[key].get<double>());
  };
  add("displacement_error", "displacement off by (of the size)");
  add("displacement_error_bound", "at most");
  add("force_error", "force off by (of the load)");
  return text;
}

Json rig_json(const SurfaceRig* rig) {
  if (rig == nullptr) return nullptr;
  Json json = {{"bones", Json::array()}, {"clips", Json::array()}};
  for (const RigBone& bone : rig->bones) json["bones"].push_back(bone.name);
  for (const RigClip& clip : rig->clips)
    json["clips"].push_back(
        {{"name", clip.name}, {"start", clip.times.front()}, {"end", clip.times.back()}});
  return json;
}

void print_rig(const SurfaceRig& rig) {
  std::vector<std::string> bones, clips;
  for (const RigBone& bone : rig.bones) bones.push_back(bone.name);
  for (const RigClip& clip : rig.clips)
    clips.push_back(
        fmt::format("'{}' ({:.4g} to {:.4g} s)", clip.name, clip.times.front(), clip.times.back()));
  show("    bones: {}\n", fmt::join(bones, ", "));
  if (!clips.empty()) show("    clips: {}\n", fmt::join(clips, ", "));
}

Json render_json(const std::optional<RenderBlock>& render) {
  if (!render) return nullptr;
  const RenderSurface& surface = render->surface;
  return {{"vertices", surface.vertices.size()}, {"triangles", surface.triangles.size()},
          {"objects", surface.objects},          {"materials", surface.materials},
          {"normals", !surface.normals.empty()}, {"uvs", !surface.uvs.empty()},
          {"colours", !surface.colours.empty()}, {"authored_vertices", surface.authored()},
          {"rig", rig_json(surface.rig.get())}};
}

void print_render(const RenderSurface& surface) {
  std::string with;
  if (!surface.normals.empty()) with += ", normals";
  if (!surface.uvs.empty()) with += ", texture coordinates";
  if (!surface.colours.empty()) with += ", colours";
  show("  render surface: {} vertices, {} triangles{}\n", surface.vertices.size(),
       surface.triangles.size(), with);
  show("    objects: {}\n    materials: {}\n", fmt::join(surface.objects, ", "),
       fmt::join(surface.materials, ", "));
  if (surface.authored() < surface.vertices.size())
    show("    {} vertices of the author's file, the others are copies at seams\n",
         surface.authored());
  if (surface.rig != nullptr) print_rig(*surface.rig);
}

// Prints the vertices of --select.
int print_selection(BasisReader& reader, const Contents& contents, const std::string& select,
                    bool json) {
  const Result<VertexBlock> surface =
      reader.vertex_block(layout::kSurfaceIds, layout::kSurfaceRest, layout::kSurfaceBasis);
  if (!surface) return report_error(surface.error());
  const Result<Selection> chosen =
      select_on_boundary(select, {*surface, contents.render ? &*contents.render : nullptr,
                                  contents.load, reader.dimensions().vertices});
  if (!chosen) return report_error(chosen.error());
  for (const std::string& note : chosen->notes) tell("  {}\n", note);
  if (json) {
    const BoundingBox box = bounding_box(chosen->places);
    print_json(Json{{"selector", select},
                    {"vertices", chosen->ids},
                    {"low", {box.low.x(), box.low.y(), box.low.z()}},
                    {"high", {box.high.x(), box.high.y(), box.high.z()}}});
  } else {
    show("{}\n", describe_vertices(chosen->ids, chosen->places));
  }
  return 0;
}

Json to_json(const std::string& path, const BasisReader& reader, const Contents& contents) {
  const BasisDimensions& d = reader.dimensions();
  const Json& provenance = contents.provenance;
  Json json;
  json["file"] = path;
  json["format_version"] = fmt::format("{}.{}", layout::kMajor, reader.minor_version());
  json["encoding"] = encoding_json(reader, provenance);
  json["linear"] = reader.linear();
  json["strain_gram"] = reader.has(layout::kStrainGram);
  json["order"] = reader.order();
  json["n"] = d.vertices;
  json["m"] = d.tetrahedra;
  json["r"] = d.modes;
  json["linear_modes"] = d.linear_modes;
  json["rigid_modes"] = d.rigid;
  json["fixed_vertices"] = d.fixed;
  json["surface_vertices"] = d.surface_vertices;
  json["triangles"] = d.triangles;
  json["render"] = render_json(contents.render);
  json["frequencies_hz"] = contents.frequencies;
  json["explicit_step_limit_s"] = step_limit(contents);
  json["resolving_step_s"] = resolving_step(contents.frequencies.front());
  json["warnings"] = warnings_of(contents);
  json["mass_orthonormality_error"] =
      provenance.is_object() ? provenance.value("mass_orthonormality_error", Json()) : Json();
  json["default_load"] = load_json(contents.load);
  json["sections"] = sections_json(reader);
  json["provenance"] = provenance;
  return json;
}

void print_text(const std::string& path, const BasisReader& reader, const Contents& contents) {
  const BasisDimensions& d = reader.dimensions();
  show("{}: basis file {}.{}, all checksums good\n", path, layout::kMajor, reader.minor_version());
  show("  {} vertices ({} on the surface, {} fixed), {} tetrahedra, {} triangles\n", d.vertices,
       d.surface_vertices, d.fixed, d.tetrahedra, d.triangles);
  if (reader.order() == 2) show("  quadratic elements: edge points are among the vertices\n");
  if (contents.render) print_render(contents.render->surface);
  show("  {} coordinates{}{}\n", d.modes,
       d.linear_modes > 0 ? fmt::format(" from {} linear modes", d.linear_modes) : "",
       d.rigid > 0 ? fmt::format("; a free body, {} rigid motions left out", d.rigid) : "");
  show("  {}\n", encoding_text(encoding_json(reader, contents.provenance)));
  if (reader.linear()) show("  a linear model: no cubic, no quartic terms\n");
  if (!reader.linear() && !reader.has(layout::kStrainGram))
    show(
        "  no section strain_gram: stiffness damping (beta) takes the positive part of the tangent "
        "stiffness; a file that tremolo-precompute makes today has it\n");
  show("  frequencies {:.4g} Hz\n", fmt::join(contents.frequencies, " "));
  show("  explicit methods are stable below a step of {:.4g} s\n", step_limit(contents));
  show("  the first mode makes {:g} steps a period with a step of {:.4g} s\n", kStepsAPeriod,
       resolving_step(contents.frequencies.front()));
  for (std::size_t i = 0; i < contents.load.vertices.size() && i < 4; ++i) {
    const Eigen::Vector3d& f = contents.load.forces[i];
    show("  default load at vertex {}: {:g}, {:g}, {:g} N\n", contents.load.vertices[i], f.x(),
         f.y(), f.z());
  }
  show("  {:<16} {:>12} {:>10} {:>8}\n", "section", "bytes", "rows", "columns");
  for (const BasisSection& s : reader.sections())
    show("  {:<16} {:>12} {:>10} {:>8}\n", s.name, s.size, s.rows, s.columns);
  if (contents.provenance.is_object()) show("{}", json_text(contents.provenance));
}

}  // namespace

int inspect_command(const std::string& path, const std::string& select, bool json) {
  Result<BasisReader> reader = BasisReader::open(path);
  if (!reader) return report_error(reader.error());
  Result<Contents> contents = read_contents(*reader);
  if (!contents) return report_error(error_of_file(path, contents.error()));
  if (Status status = check_model(*reader); !status)
    return report_error(error_of_file(path, status.error()));
  if (!select.empty()) {
    if (const int code = print_selection(*reader, *contents, select, json); code != 0) return code;
  } else if (json) {
    print_json(to_json(path, *reader, *contents));
  } else {
    print_text(path, *reader, *contents);
  }
  if (select.empty()) print_warnings(warnings_of(*contents));
  return flushed(0);
}

}  // namespace tremolo
