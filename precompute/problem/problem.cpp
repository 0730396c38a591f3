#include "precompute/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/hash.h"
#include "common/mesh/selector.h"
#include "common/mesh/surface_mesh.h"
#include "common/packed_index.h"
#include "common/text.h"
#include "common/units.h"
#include "formats/basis/selector_reader.h"
#include "formats/surface/surface_reader.h"
#include "precompute/embedding/surface_sets.h"
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

Chosen select_all(const std::vector<Selector>& selectors, const TetMesh& mesh) {
  Chosen all;
  for (const Selector& selector : selectors) {
    const std::vector<VertexId> chosen = unwrap(resolve_selector(selector, mesh));
    all.vertices.insert(all.vertices.end(), chosen.begin(), chosen.end());
    if (!means_surface(selector))
      all.by_place.insert(all.by_place.end(), chosen.begin(), chosen.end());
  }
  for (std::vector<VertexId>* ids : {&all.vertices, &all.by_place}) {
    std::sort(ids->begin(), ids->end());
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
  }
  return all;
}

// Adds notes that name the vertices chosen by `near:` selectors.
void note_near(const ProblemRequest& request, Problem& problem) {
  const auto note = [&](const char* flag, const Selector& selector) {
    for (const std::string& each : near_notes(selector, problem.mesh))
      problem.notes.push_back(std::string(flag) + " " + each);
  };
  for (const Selector& selector : request.support.fixed) note("--fix", selector);
  constexpr const char* kFlags[] = {"--fix-x", "--fix-y", "--fix-z"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const Selector& selector : request.support.along[axis]) note(kFlags[axis], selector);
  if (request.load) note("--load-at", request.load->at);
  for (const PointMassRequest& mass : request.point_masses) note("--point-mass", mass.at);
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

MaterialTable make_materials(const MaterialRequest& request,
                             const std::vector<FileMaterial>& of_file, Problem& problem) {
  MaterialTable table =
      unwrap(assign_materials(request.rules, request.usual, problem.mesh, of_file));
  const bool several = problem.mesh.region_names.size() > 1;
  if (request.rules.empty() && (several || !of_file.empty()))
    problem.notes.push_back(list_regions(problem.mesh) +
                            ": all of one material without --material" +
                            (of_file.empty() ? ""
                                             : "; the file's own are not used without "
                                               "--material file"));
  return table;
}

std::vector<PointMass> make_point_masses(const std::vector<PointMassRequest>& requests,
                                         Problem& problem) {
  std::vector<PointMass> masses;
  for (const PointMassRequest& request : requests) {
    masses.push_back(unwrap(place_point_mass(request, problem.mesh, problem.fixed)));
    const PointMass& mass = masses.back();
    if (mass.fixed > 0)
      problem.notes.push_back("--point-mass " + request.text + ": " + std::to_string(mass.fixed) +
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

std::string up_axis_hint(const SolidFiles& files, const std::vector<Selector>& selectors,
                         const TetMesh& mesh) {
  return files.y_up ? std::string() : side_hint(selectors, mesh, has_y_up(files.mesh));
}

DefaultLoad make_load(const LoadRequest& request, const Problem& problem) {
  DefaultLoad load;
  const std::vector<VertexId> chosen = unwrap(resolve_selector(request.at, problem.mesh));
  const std::vector<double> shares = shares_of(chosen, problem.mesh);
  double total = 0;
  std::vector<double> of_free;
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    if (std::binary_search(problem.fixed.begin(), problem.fixed.end(), chosen[n])) continue;
    load.vertices.push_back(chosen[n]);
    of_free.push_back(shares[n]);
    total += shares[n];
  }
  if (load.vertices.empty()) {
    std::string message = "--load-at " + request.at.text + ": every such vertex is fixed";
    const std::vector<std::string> near = near_notes(request.at, problem.mesh);
    for (const std::string& each : near) message += "; " + each;
    if (!near.empty())
      message += ". The mesh is " + number_text(bounding_box(problem.mesh.vertices).diagonal()) +
                 " m across: if its unit is not 1 m, say so by --unit";
    throw Failure(content_error(message));
  }
  // The part of the force on a face's fixed vertices is distributed over the others.
  const auto count = static_cast<double>(load.vertices.size());
  for (const double share : of_free)
    load.forces.push_back((total > 0 ? share / total : 1.0 / count) * request.force);
  return load;
}

void attach_render(Problem& problem, RenderSurface surface, unsigned threads) {
  const auto note = [&problem](std::vector<std::string> notes) {
    for (std::string& each : notes) problem.notes.push_back(std::move(each));
  };
  problem.embedding = embed_surface(surface, problem.mesh, threads);
  note(describe(problem.embedding, problem.mesh));
  note(add_surface_sets(surface, problem.mesh));
  problem.render = std::move(surface);
}

namespace {

// The tetrahedra as read, and what their files say besides.
struct ReadSolid {
  TetMesh mesh;
  std::string format;
  std::vector<std::string> notes;
  std::optional<RenderSurface> drawn;   // the surface that was meshed
  std::vector<FileMaterial> materials;  // of the mesh file
};

// Reads a surface or a tetrahedral mesh.
ReadSolid read_solid(const SolidFiles& files, bool imported) {
  if (is_surface_file(files.mesh)) {
    if (files.mesh_unit)
      throw Failure({ErrorKind::kUsage,
                     "--mesh-unit applies to a tetrahedral mesh's coordinates: " + files.mesh +
                         " is a surface, see --unit"});
    if (files.merge)
      throw Failure(
          {ErrorKind::kUsage,
           "--merge applies to a tetrahedral mesh: the corners of a surface that lie at one "
           "place are joined in any case"});
    CutSurface surface = cut_surface(files);
    return {std::move(surface.cut.mesh),
            std::move(surface.cut.format),
            std::move(surface.cut.notes),
            std::move(surface.render),
            {}};
  }
  MeshFile file = load_tetrahedra(files, imported);
  return {std::move(file.mesh), std::move(file.format), std::move(file.notes), std::nullopt,
          std::move(file.materials)};
}

// The surface of --render, in metres, with z up. Adds notes.
RenderSurface read_render(const SolidFiles& files, std::vector<std::string>& notes) {
  SurfaceFile file = unwrap(read_surface(files.render, {files.unit ? files.unit->metres : 0.0}));
  notes.push_back("render surface: " + files.render + ", " + file.format + ", unit: " + file.unit);
  notes.insert(notes.end(), file.notes.begin(), file.notes.end());
  if (files.y_up) turn_y_to_z(file.surface);
  return std::move(file.surface);
}

// Selects the fixed vertices and checks that they suffice.
void hold(const ProblemRequest& request, Problem& problem) {
  HeldByPlace& by_place = problem.by_place;
  problem.free_body = request.support.free_body();
  if (!problem.free_body) {
    Chosen fixed = select_all(request.support.fixed, problem.mesh);
    problem.fixed = std::move(fixed.vertices);
    by_place.fixed = std::move(fixed.by_place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Chosen held = select_all(request.support.along[axis], problem.mesh);
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

Problem load_solid(const ProblemRequest& request) {
  const SolidFiles& files = request.files;
  ReadSolid read = read_solid(files, request.imported);
  if (files.y_up) {
    turn_y_to_z(read.mesh);
    turn_y_to_z(read.materials);
    if (read.drawn) turn_y_to_z(*read.drawn);
    read.notes.emplace_back("turned from y up to z up: (x, y, z) -> (x, -z, y)");
  }
  Problem problem;
  problem.mesh = std::move(read.mesh);
  problem.mesh_format = std::move(read.format);
  problem.notes = std::move(read.notes);
  Result<MeshReport> report = check_mesh(problem.mesh);
  if (!report) throw Failure({report.error().kind, files.mesh + ": " + report.error().message});
  problem.report = std::move(*report);
  problem.notes.insert(problem.notes.end(), problem.report.notes.begin(),
                       problem.report.notes.end());
  prepare_edges(request, problem);
  problem.mesh_hash = hash_mesh(problem.mesh);
  // The file's numbers are those of the surface that was meshed, whichever is drawn.
  if (read.drawn) add_given_vertices(*read.drawn, problem.mesh);
  if (!files.render.empty()) read.drawn = read_render(files, problem.notes);
  // Before the surface adds sets of the same names, which are on the boundary only.
  if (read.drawn && !request.materials.rules.empty()) add_solids(*read.drawn, problem.mesh);
  if (read.drawn) attach_render(problem, std::move(*read.drawn), request.threads);
  // This follows the render surface, since its objects and colours may select a material.
  problem.materials = make_materials(request.materials, read.materials, problem);
  return problem;
}

Problem load_problem(const ProblemRequest& request) {
  Problem problem = load_solid(request);
  const std::string hint = up_axis_hint(request.files, request.support.fixed, problem.mesh);
  if (!hint.empty()) problem.notes.push_back(hint);
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
  if (request.load) problem.load = make_load(*request.load, problem);
  problem.point_masses = make_point_masses(request.point_masses, problem);
  note_near(request, problem);
  add_edge_points(problem);
  refine(request.elements.refine, request.threads, problem);
  return problem;
}

}  // namespace tremolo
