#include "precompute/options/solid_options.h"

#include <charconv>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "common/text.h"
#include "common/units.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"
#include "precompute/mesher/surface_options.h"
#include "precompute/problem/material_rules.h"
#include "precompute/system/failure.h"
#include "precompute/system/option_checks.h"

namespace tremolo {
namespace {

CLI::Validator refinements() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        int value = -1;
        const char* end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (error == std::errc{} && stop == end && value >= 0 && value <= kMostRefine) return "";
        return "expected a whole number from 0 to " + std::to_string(kMostRefine) + ", found " +
               text;
      },
      "");
}

void add_support_options(CLI::App& app, SolidTexts& texts) {
  app.add_option("--fix", texts.fix,
                 "vertices that do not move: x<0.01, y>=90%, box:x0,y0,z0,x1,y1,z1, "
                 "sphere:x,y,z,r, plane:x,y,z,nx,ny,nz, near:x,y,z,k, vertex:ID, file:ids.txt, "
                 "colour:red, a set of the mesh, or none for a free body; may be repeated");
  constexpr const char* kAxes[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    app.add_option(std::string("--fix-") + kAxes[axis], texts.fix_axis[axis],
                   std::string("vertices that do not move along ") + kAxes[axis] +
                       " (selector); may be repeated");
  app.add_option("--load-at", texts.load_at, "vertices that the default load acts on (selector)");
  app.add_option("--load-force", texts.load_force,
                 "the default load, X,Y,Z in N, shared among them")
      ->needs("--load-at");
}

}  // namespace

bool vectors_are_words(const std::vector<std::string>& words, const std::string& flag) {
  // A trailing comma is what remains of "0, " after the shell has split the words.
  const auto number = [](std::string word) {
    if (word.ends_with(',')) word.pop_back();
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && stop == word.data() + word.size() ? word : std::string();
  };
  for (std::size_t i = 0; i + 2 < words.size(); ++i) {
    if (words[i] != flag || number(words[i + 1]).empty() || number(words[i + 2]).empty()) continue;
    const std::string third = i + 3 < words.size() ? number(words[i + 3]) : "";
    std::cerr << "tremolo-precompute: " << flag << " takes one word, X,Y,Z with commas: " << flag
              << ' ' << number(words[i + 1]) << ',' << number(words[i + 2]) << ','
              << (third.empty() ? "0" : third) << "\n";
    return false;
  }
  return true;
}

void add_solid_options(CLI::App& app, SolidTexts& texts) {
  app.add_option("mesh", texts.mesh,
                 "tetrahedral mesh (.msh .vtk .vtu .pvtu .inp .bdf .veg .vegb .node .ele), or a\n"
                 "surface (.obj .ply "
                 ".stl .gltf .glb .fbx .dae ...), which is meshed first")
      ->required();
  app.add_option("--young", texts.material.young, "Young's modulus, Pa")->capture_default_str();
  app.add_option("--poisson", texts.material.poisson, "Poisson's ratio")->capture_default_str();
  app.add_option("--density", texts.material.density, "density, kg/m^3")->capture_default_str();
  app.add_option(
      "--material", texts.materials,
      std::string("a material of a region of the mesh, later ones decide; may be repeated: ") +
          kMaterialGrammar);
  app.add_option("--point-mass", texts.point_masses,
                 "SELECTOR=KG: a mass shared by the selected vertices; may be repeated");
  add_support_options(app, texts);
  app.add_option("--mass", texts.mass,
                 "consistent or lumped; with --import-basis: the basis is made orthonormal in it")
      ->check(CLI::IsMember({"consistent", "lumped"}))
      ->capture_default_str();
  app.add_option(
         "--order", texts.order,
         "of the elements: 1 (linear), 2 (quadratic: far more accurate in bending, some six "
         "times the unknowns) or auto: 2 for a quadratic mesh, a small one, "
         "and walls of one layer")
      ->check(CLI::IsMember({"1", "2", "auto"}))
      ->capture_default_str();
  app.add_option("--refine", texts.refine,
                 "so often cut each tetrahedron into eight, after selectors have chosen: eight "
                 "times as many a time, half as long")
      ->check(refinements())
      ->capture_default_str();
  app.add_option("--surface-subdivide", texts.subdivide,
                 "draw the boundary of a quadratic body with its edge points, four triangles for "
                 "each: on, off, or auto: where it is coarse")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_option("--up", texts.up,
                 "the axis of the mesh's (and the render surface's) file that points up: y turns "
                 "them so that z does, (x, y, z) -> (x, -z, y); selectors, forces and results are "
                 "in turned coordinates")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  add_surface_options(app, texts.meshing, texts.unit);
  app.get_option("--unit")->description(
      std::string("of the surface's coordinates, or of a tetrahedral mesh's where no surface is "
                  "read: ") +
      kLengthUnits);
  app.add_option(
      "--mesh-unit", texts.mesh_unit,
      "of a tetrahedral mesh's coordinates, when --unit applies to the --render surface");
  app.add_flag(
      "--merge", texts.merge,
      "join vertices of a tetrahedral mesh that lie at one place, as where two regions were "
      "meshed or written separately");
  texts.threads = std::max(1u, std::thread::hardware_concurrency());
  app.add_option("--threads", texts.threads, "threads of a rank")->check(thread_count());
}

std::optional<int> finish_solid_options(const SolidTexts& texts, ProblemRequest& request) {
  try {
    request = read_problem_request(texts);
    return std::nullopt;
  } catch (const Failure& failure) {
    std::cerr << "tremolo-precompute: " << printable(failure.what()) << "\n";
    return exit_code(failure.error());
  }
}

namespace {

std::string require_regular(const std::string& path) {
  std::error_code ignored;
  // CLI11 reports a missing file, as it opens the file next.
  if (!std::filesystem::exists(path, ignored)) return {};
  const Result<struct stat> status = examine_input(path);
  if (!status) throw Failure(status.error());
  return {};
}

// Cuts each line at the first # outside quotes.
std::string without_comments(std::string_view text) {
  std::string kept;
  char quote = 0;
  bool comment = false;
  for (const char c : text) {
    if (c == '\n') quote = 0, comment = false;
    if (quote != 0)
      quote = c == quote ? char{0} : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '#')
      comment = true;
    if (!comment) kept.push_back(c);
  }
  return kept;
}

// CLI11's reader, which takes a byte-order mark for a part of the first key, and a # in quotes for
// the beginning of a comment.
class MarkedConfig : public CLI::ConfigTOML {
 public:
  MarkedConfig() { comment('\x01'); }  // comments are gone when it reads
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    const std::string text(std::istreambuf_iterator<char>(input), {});
    std::istringstream plain(without_comments(without_mark(text)));
    return CLI::ConfigTOML::from_config(plain);
  }
};

}  // namespace

void add_config_option(CLI::App& app, const std::string& description) {
  app.config_formatter(std::make_shared<MarkedConfig>());
  app.set_config("--config", "", description)->check(require_regular, "FILE");
}

std::string config_path(const CLI::App& app) {
  const CLI::Option* option = app.get_config_ptr();
  return option->count() > 0 ? option->as<std::string>() : std::string();
}

}  // namespace tremolo
