#include "precompute/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/hash.h"
#include "common/mesh/selector.h"
#include "common/mesh/surface_mesh.h"
#include "common/packed_index.h"
#include "common/units.h"
#include "formats/basis/selector_reader.h"
#include "formats/surface/surface_reader.h"
#include "precompute/embedding/surface_sets.h"
#include "precompute/problem/cut_surface.h"
#include "precompute/problem/element_order.h"
#include "precompute/problem/material_rules.h"
#include "precompute/problem/mechanisms.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/problem/tet_input.h"
#include "precompute/problem/up_axis.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::string hash_mesh(const TetMesh& mesh) {
  const std::uint64_t parts[] = {hash_bytes(std::as_bytes(std::span(mesh.vertices))),
                                 hash_bytes(std::as_bytes(std::span(mesh.tetrahedra)))};
  return hash_text(hash_bytes(std::as_bytes(std::span(parts))));
}

// The vertices chosen by some selectors; both lists are ascending. by_place: chosen by selectors
// that are not limited to the surface.
struct Chosen {
  std::vector<VertexId> vertices;
  std::vector<VertexId> by_place;
};

Chosen select_all(const std::vector<std::string>& selectors, const TetMesh& mesh) {
  Chosen all;
  for (const std::string& selector : selectors) {
    const std::vector<VertexId> chosen = unwrap(resolve_selector(selector, mesh));
    all.vertices.insert(all.vertices.end(), chosen.begin(), chosen.end());
    if (!means_surface(unwrap(parse_selector(selector))))
      all.by_place.insert(all.by_place.end(), chosen.begin(), chosen.end());
  }
  for (std::vector<VertexId>* ids : {&all.vertices, &all.by_place}) {
    std::sort(ids->begin(), ids->end());
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
  }
  return all;
}

void require_force(const ProblemRequest& request) {
  if (!request.load_at.empty() &&
      (!request.load_force.allFinite() || request.load_force.norm() == 0.0))
    throw Failure(
        content_error("--load-at needs --load-force with a finite force other than zero"));
}

void require_selector(const std::string& text) {
  if (!text.empty()) unwrap(parse_selector(text));
}

// Rejects options that are wrong for every mesh before a mesh is read.
void require_well_formed(const ProblemRequest& request) {
  for (const std::string& text : request.fix) require_selector(text);
  for (const auto& selectors : request.fix_axis)
    for (const std::string& text : selectors) require_selector(text);
  require_selector(request.load_at);
  require_selector(request.select);
  for (const std::string& text : request.point_masses) unwrap(parse_point_mass(text));
  if (!request.unit.empty()) unwrap(metres_per_unit(request.unit));
  if (!request.select.empty()) return;
  require_force(request);
}

// Adds notes that name the vertices chosen by `near:` selectors.
void note_near(const ProblemRequest& request, Problem& problem) {
  const auto note = [&](const char* flag, const std::string& text) {
    for (const std::string& each : near_notes(text, problem.mesh))
      problem.notes.push_back(std::string(flag) + " " + each);
  };
  for (const std::string& text : request.fix) note("--fix", text);
  constexpr const char* kFlags[] = {"--fix-x", "--fix-y", "--fix-z"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::string& text : request.fix_axis[axis]) note(kFlags[axis], text);
  note("--load-at", request.load_at);
  for (const PointMass& mass : problem.point_masses) note("--point-mass", mass.selector);
}

// Returns a hint about the up axis, or an empty string; with --up y the user has already decided.
std::string up_axis_hint(const ProblemRequest& request, const Problem& problem) {
  if (request.y_up) return {};
  std::vector<std::string> selectors = request.fix;
  selectors.push_back(request.select);
  return side_hint(selectors, problem.mesh, has_y_up(request.mesh_path));
}

// Throws if a part can still move rigidly, which would make K singular. Joints between pieces are
// not checked when vertices are held along single axes.
void require_held(const Problem& problem) {
  const std::vector<int> freedom =
      rigid_freedom(problem.mesh, problem.report.part_of_vertex,
                    static_cast<int>(problem.report.parts), problem.fixed, problem.held);
  for (std::size_t part = 0; part < freedom.size(); ++part) {
    if (freedom[part] == 0) continue;
    const auto& labels = problem.report.part_of_vertex;
    const auto first = std::find(labels.begin(), labels.end(), static_cast<int>(part));
    const Eigen::Vector3d x = problem.mesh.vertices[first - labels.begin()];
    const auto count = std::count(labels.begin(), labels.end(), static_cast<int>(part));
    throw Failure(content_error(
        "part " + std::to_string(part + 1) + " of " + std::to_string(freedom.size()) + " (" +
        std::to_string(count) + " vertices, one at " + std::to_string(x.x()) + ", " +
        std::to_string(x.y()) + ", " + std::to_string(x.z()) +
        ") is not held: " + std::to_string(freedom[part]) +
        " rigid motions are left. Hold it with --fix SELECTOR (or --fix-x, --fix-y, --fix-z along "
        "one axis), or ask for a free body with --fix none"));
  }
}

MaterialTable make_materials(const ProblemRequest& request, const std::vector<MaterialRule>& rules,
                             const std::vector<FileMaterial>& of_file, Problem& problem) {
  MaterialTable table = unwrap(assign_materials(rules, request.material, problem.mesh, of_file));
  const bool several = problem.mesh.region_names.size() > 1;
  if (rules.empty() && (several || !of_file.empty()))
    problem.notes.push_back(list_regions(problem.mesh) +
                            ": all of one material without --material" +
                            (of_file.empty() ? ""
                                             : "; the file's own are not used without "
                                               "--material file"));
  return table;
}

std::vector<PointMass> make_point_masses(const ProblemRequest& request, Problem& problem) {
  std::vector<PointMass> masses;
  for (const std::string& text : request.point_masses) {
    masses.push_back(unwrap(read_point_mass(text, problem.mesh, problem.fixed)));
    const PointMass& mass = masses.back();
    if (mass.fixed > 0)
      problem.notes.push_back("--point-mass " + text + ": " + std::to_string(mass.fixed) +
                              " of its " + std::to_string(mass.vertices.size()) +
                              " vertices are fixed, where a mass does nothing");
  }
  return masses;
}

// On a face by its area. The mesh is linear at this stage.
std::vector<double> shares_of(const std::vector<VertexId>& chosen, const TetMesh& mesh) {
  if (chosen.empty()) return {};
  const BoundarySurface boundary = boundary_surface(mesh);
  std::vector<Eigen::Vector3d> rest;
  for (const VertexId id : boundary.vertex_ids) rest.push_back(mesh.vertices[id]);
  return area_shares(chosen, boundary.vertex_ids, boundary.triangles, rest);
}

}  // namespace

DefaultLoad make_load(const ProblemRequest& request, const Problem& problem) {
  DefaultLoad load;
  if (request.load_at.empty()) return load;
  require_force(request);
  const std::vector<VertexId> chosen = unwrap(resolve_selector(request.load_at, problem.mesh));
  const std::vector<double> shares = shares_of(chosen, problem.mesh);
  double total = 0;
  std::vector<double> of_free;
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    if (std::binary_search(problem.fixed.begin(), problem.fixed.end(), chosen[n])) continue;
    load.vertices.push_back(chosen[n]);
    of_free.push_back(shares[n]);
    total += shares[n];
  }
  if (load.vertices.empty())
    throw Failure(content_error("--load-at " + request.load_at + ": every such vertex is fixed"));
  // The part of the force on a face's fixed vertices is distributed over the others.
  const auto count = static_cast<double>(load.vertices.size());
  for (const double share : of_free)
    load.forces.push_back((total > 0 ? share / total : 1.0 / count) * request.load_force);
  return load;
}

namespace {

void read_render(const ProblemRequest& request, Problem& problem) {
  SurfaceReadOptions reading;
  if (!request.unit.empty()) reading.metres_per_unit = unwrap(metres_per_unit(request.unit));
  SurfaceFile file = unwrap(read_surface(request.render_path, reading));
  problem.notes.push_back("render surface: " + request.render_path + ", " + file.format +
                          ", unit: " + file.unit);
  problem.notes.insert(problem.notes.end(), file.notes.begin(), file.notes.end());
  if (request.y_up) turn_y_to_z(file.surface);
  attach_render(problem, std::move(file.surface), request.threads);
}

}  // namespace

void attach_render(Problem& problem, RenderSurface surface, unsigned threads) {
  const auto note = [&problem](std::vector<std::string> notes) {
    for (std::string& each : notes) problem.notes.push_back(std::move(each));
  };
  problem.embedding = embed(surface.vertices, problem.mesh, threads);
  note(describe(problem.embedding, problem.mesh));
  note(add_surface_sets(surface, problem.mesh));
  problem.render = std::move(surface);
}

namespace {

// Rejects contradictory options that can be recognised without reading a file.
void require_consistent(const ProblemRequest& request) {
  const auto refuse = [](const std::string& text) { throw Failure({ErrorKind::kUsage, text}); };
  if (request.fix.size() > 1 &&
      std::find(request.fix.begin(), request.fix.end(), "none") != request.fix.end())
    refuse("--fix none and another --fix contradict each other");
  for (const auto& selectors : request.fix_axis)
    if (!selectors.empty() && request.fix.size() == 1 && request.fix.front() == "none")
      refuse("--fix none and --fix-x, --fix-y or --fix-z contradict each other");
}

// Reads a surface or a tetrahedral mesh. meshed: the surface that was meshed; of_file: the
// materials of the mesh file.
void read_solid(const ProblemRequest& request, Problem& problem,
                std::optional<RenderSurface>& meshed, std::vector<FileMaterial>& of_file) {
  if (is_surface_file(request.mesh_path)) {
    if (!request.mesh_unit.empty())
      throw Failure(
          {ErrorKind::kUsage, "--mesh-unit applies to a tetrahedral mesh's coordinates: " +
                                  request.mesh_path + " is a surface, see --unit"});
    if (request.merge)
      throw Failure(
          {ErrorKind::kUsage,
           "--merge applies to a tetrahedral mesh: the corners of a surface that lie at one "
           "place are joined in any case"});
    CutSurface surface = cut_surface(request);
    problem.mesh = std::move(surface.cut.mesh);
    problem.mesh_format = std::move(surface.cut.format);
    problem.notes = std::move(surface.cut.notes);
    meshed = std::move(surface.render);
    return;
  }
  MeshFile file = load_tetrahedra(request);
  problem.mesh = std::move(file.mesh);
  problem.mesh_format = std::move(file.format);
  problem.notes = std::move(file.notes);
  of_file = std::move(file.materials);
}

// Selects the fixed vertices and checks that they suffice.
void hold(const ProblemRequest& request, Problem& problem) {
  HeldByPlace& by_place = problem.by_place;
  problem.free_body = request.fix.size() == 1 && request.fix.front() == "none";
  if (!problem.free_body) {
    Chosen fixed = select_all(request.fix, problem.mesh);
    problem.fixed = std::move(fixed.vertices);
    by_place.fixed = std::move(fixed.by_place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Chosen held = select_all(request.fix_axis[axis], problem.mesh);
      problem.held[axis] = std::move(held.vertices);
      by_place.along[axis] = std::move(held.by_place);
    }
  }
  const bool along_axes = std::any_of(problem.held.begin(), problem.held.end(),
                                      [](const auto& held) { return !held.empty(); });
  // An imported basis defines its own fixed vertices.
  if (!request.imported && along_axes) require_held(problem);
  if (!request.imported && !along_axes)
    require_no_loose_piece(problem.mesh, problem.report, problem.fixed, problem.free_body);
  if (problem.free_body && problem.report.parts > kMostFreeParts)
    throw Failure(
        content_error("a free body of " + std::to_string(problem.report.parts) +
                      " parts that do not touch: each moves by itself, and at most " +
                      std::to_string(kMostFreeParts) +
                      " are taken. Make a model of each, join them, or hold them with --fix"));
  if (problem.free_body)
    for (std::string& note : rigid_motion_notes(problem.mesh, problem.report))
      problem.notes.push_back(std::move(note));
}

}  // namespace

Problem load_problem(const ProblemRequest& request) {
  unwrap(check_material(request.material));
  std::vector<MaterialRule> rules;
  for (const std::string& text : request.materials)
    rules.push_back(unwrap(parse_material_rule(text, request.material)));
  require_consistent(request);
  require_well_formed(request);
  Problem problem;
  std::optional<RenderSurface> meshed;
  std::vector<FileMaterial> of_file;
  read_solid(request, problem, meshed, of_file);
  if (request.y_up) {
    turn_y_to_z(problem.mesh);
    turn_y_to_z(of_file);
    if (meshed) turn_y_to_z(*meshed);
    problem.notes.emplace_back("turned from y up to z up: (x, y, z) -> (x, -z, y)");
  }
  Result<MeshReport> report = check_mesh(problem.mesh);
  if (!report)
    throw Failure({report.error().kind, request.mesh_path + ": " + report.error().message});
  problem.report = std::move(*report);
  problem.notes.insert(problem.notes.end(), problem.report.notes.begin(),
                       problem.report.notes.end());
  prepare_edges(request, problem);
  problem.mesh_hash = hash_mesh(problem.mesh);
  if (!request.render_path.empty())
    read_render(request, problem);
  else if (meshed)
    attach_render(problem, std::move(*meshed), request.threads);
  // This follows the render surface, since its objects and colours may select a material.
  problem.materials = make_materials(request, rules, of_file, problem);
  const std::string hint = up_axis_hint(request, problem);
  if (!hint.empty()) problem.notes.push_back(hint);
  if (!request.select.empty()) {
    for (std::string& note : near_notes(request.select, problem.mesh))
      problem.notes.push_back(std::move(note));
    return problem;
  }
  try {
    hold(request, problem);
  } catch (const Failure& failure) {
    const auto coincident =
        std::find_if(problem.notes.begin(), problem.notes.end(),
                     [](const std::string& note) { return note.ends_with(kCoincidentNote); });
    if (hint.empty() && coincident == problem.notes.end()) throw;
    Error error = failure.error();
    if (coincident != problem.notes.end()) error.message += ". A hint: " + *coincident;
    if (!hint.empty()) error.message += ". A hint: " + hint;
    throw Failure(std::move(error));
  }
  problem.load = make_load(request, problem);
  problem.point_masses = make_point_masses(request, problem);
  note_near(request, problem);
  add_edge_points(problem);
  refine(request.refine, request.threads, problem);
  return problem;
}

}  // namespace tremolo
