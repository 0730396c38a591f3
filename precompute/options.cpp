#include "precompute/options.h"

#include <charconv>
#include <cstdio>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>

#include "precompute/material_rules.h"
#include "precompute/mesher/surface_options.h"

namespace tremolo {
namespace {

bool parse_vector(const std::string& text, Eigen::Vector3d& vector) {
  const char* at = text.data();
  const char* end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [next, error] = std::from_chars(at, end, vector[axis]);
    if (error != std::errc{}) return false;
    at = next;
    if (axis < 2) {
      if (at == end || *at != ',') return false;
      ++at;
    }
  }
  return at == end;
}

// What shaped the result: where it went, how many threads worked and what was printed is left out,
// so that the same model gives the same file.
std::string essential(const std::vector<std::string>& words) {
  std::string line;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--json" || word == "--limits" || word.starts_with("--output=") ||
        word.starts_with("--modes-vtu=") || word.starts_with("--threads=") ||
        (word.starts_with("-o") && word.size() > 2))
      continue;
    if (word == "-o" || word == "--output" || word == "--threads" || word == "--modes-vtu") {
      ++i;
      continue;
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return line;
}

}  // namespace

std::variant<CommandLine, int> parse_command_line(int count, char** words) {
  CommandLine line;
  PrecomputeOptions& options = line.options;
  std::vector<std::string> own;
  int at = 1;
  for (; at < count && std::string(words[at]) != "--"; ++at) own.emplace_back(words[at]);
  options.command_line = essential(own);
  for (++at; at < count; ++at) line.petsc_options.emplace_back(words[at]);

  CLI::App app{
      "Turns a tetrahedral mesh into a basis file for tremolo. Units are SI.\n"
      "What follows -- goes to PETSc and SLEPc (their inner solver has the prefix -st_)."};
  app.name("tremolo-precompute");
  app.set_version_flag("--version", std::string("tremolo-precompute ") + TREMOLO_VERSION);
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.set_config("--config", "", "read options from a TOML file (keys are the long flag names)");
  app.add_option(
         "mesh", options.mesh_path,
         "tetrahedral mesh (.msh .vtk .vtu .veg .vegb .node .ele), or a surface (.obj .ply\n"
         ".stl .gltf .glb .fbx .dae ...), which is meshed first")
      ->required();
  app.add_option("-o,--output", options.output_path, "the basis file to write");
  app.add_option(
      "--render", options.render_path,
      "surface that is drawn in place of the mesh's boundary and moves with it: .obj .ply "
      ".stl .gltf .glb .fbx ... (default: the surface that was meshed)");
  app.add_option("--select", options.select,
                 "print the vertices that a selector chooses, and compute nothing");
  app.add_option("--young", options.material.young, "Young's modulus, Pa")->capture_default_str();
  app.add_option("--poisson", options.material.poisson, "Poisson's ratio")->capture_default_str();
  app.add_option("--density", options.material.density, "density, kg/m^3")->capture_default_str();
  app.add_option(
      "--material", options.materials,
      std::string("a material of a region of the mesh, later ones decide; may be repeated: ") +
          kMaterialGrammar);
  app.add_option("--point-mass", options.point_masses,
                 "SELECTOR=KG: a mass shared by the selected vertices; may be repeated");
  app.add_option("--fix", options.fix,
                 "vertices that do not move: x<0.01, y>=90%, box:x0,y0,z0,x1,y1,z1, "
                 "sphere:x,y,z,r, plane:x,y,z,nx,ny,nz, near:x,y,z,k, vertex:ID, file:ids.txt, "
                 "colour:red, a set of the mesh, or none for a free body; may be repeated");
  app.add_option("--load-at", options.load_at, "vertices that the default load acts on (selector)");
  std::string force;
  app.add_option("--load-force", force, "the default load, X,Y,Z in N, shared among them")
      ->needs("--load-at");
  CLI::Option* linear_modes =
      app.add_option("--linear-modes", options.linear_modes, "K, linear modes (default 20)");
  CLI::Option* modes =
      app.add_option("--modes", options.modes, "R, coordinates to keep (default 30)");
  std::string mass = "consistent";
  CLI::Option* mass_option =
      app.add_option(
             "--mass", mass,
             "consistent or lumped; with --import-basis: the basis is made orthonormal in it")
          ->check(CLI::IsMember({"consistent", "lumped"}))
          ->capture_default_str();
  app.add_flag("--certify,!--no-certify", options.certify,
               "count the modes by inertia as well: one more factorisation (default: yes)");
  CLI::Option* linear =
      app.add_flag("--linear", options.linear,
                   "the linear modes alone: no derivatives, no cubic and quartic terms");
  std::string encoding = "full";
  app.add_option("--encoding", encoding,
                 "full (f64), or compact: coefficients f32, basis rows 16 bits; the error is told")
      ->check(CLI::IsMember({"full", "compact"}))
      ->capture_default_str();
  app.add_option("--import-basis", options.import_basis,
                 "VegaFEM's basis, .U, over the vertices of this mesh: nothing is solved. It is "
                 "orthonormal in the lumped mass, of which --density is part (--material file: the "
                 "mesh file's own)")
      ->excludes(linear_modes)
      ->excludes(modes)
      ->excludes(linear)
      ->excludes(app.get_option("--point-mass"));
  app.add_option("--import-cubic", options.import_cubic,
                 "VegaFEM's polynomials of the reduced forces, .cub; the stiffness is theirs")
      ->needs("--import-basis");
  app.get_option("--import-basis")->needs("--import-cubic");
  app.add_option("--modes-vtu", options.modes_vtu,
                 "also write the modes on the tetrahedra, .vtu, for ParaView and meshio");
  add_surface_options(app, options.meshing, options.unit);
  options.threads = std::max(1u, std::thread::hardware_concurrency());
  app.add_option("--threads", options.threads, "threads of a rank")->check(CLI::PositiveNumber);
  app.add_flag("--limits", options.limits,
               "measure this machine and print the shortest time each stage could take on it");
  app.add_flag("--json", line.json, "print one JSON object on stdout");

  try {
    std::vector<std::string> reversed(own.rbegin(), own.rend());
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error, std::cout, std::cerr);
    return code == 0 ? 0 : exit_code({ErrorKind::kUsage, ""});
  }
  if (options.output_path.empty() && options.select.empty()) {
    std::cerr << "tremolo-precompute: --output is required\n";
    return exit_code({ErrorKind::kUsage, ""});
  }
  options.encoding = encoding == "compact" ? BasisEncoding::kCompact : BasisEncoding::kFull;
  options.mass_given = mass_option->count() > 0;
  options.mass = mass == "lumped" ? MassKind::kLumped : MassKind::kConsistent;
  if (!force.empty() && !parse_vector(force, options.load_force)) {
    std::cerr << "tremolo-precompute: --load-force " << force
              << ": expected three numbers, X,Y,Z in N\n";
    return exit_code({ErrorKind::kUsage, ""});
  }
  return line;
}

}  // namespace tremolo
