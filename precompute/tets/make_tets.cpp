#include "precompute/tets/make_tets.h"

#include <filesystem>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/mesh/edge_points.h"
#include "common/mesh/surface_mesh.h"
#include "common/stage_log.h"
#include "common/text.h"
#include "formats/file/atomic_file.h"
#include "formats/file/output_guard.h"
#include "formats/file/standard_streams.h"
#include "formats/tets/tets_file.h"
#include "precompute/collider/closed_surface.h"
#include "precompute/collider/collider_grid.h"
#include "precompute/collider/collider_options.h"
#include "precompute/collider/surface_distance.h"
#include "precompute/options/named_files.h"
#include "precompute/problem/problem.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using TetsJson = nlohmann::ordered_json;

// The solid's boundary, or the given surface, with its weights on the tetrahedra.
TetsSurface drawn_surface(const Problem& problem, unsigned threads) {
  TetsSurface drawn;
  Embedding embedding;
  if (problem.render) {
    drawn.vertices = problem.render->vertices;
    drawn.triangles = problem.render->triangles;
    drawn.uvs = problem.render->uvs;
    drawn.sources = problem.render->sources;
    embedding = problem.embedding;
  } else {
    // With the edges' middles, where a quadratic edge shows that it is bent.
    TetMesh mesh = problem.mesh;
    if (mesh.edges.empty()) unwrap(add_edge_points(mesh));
    const BoundarySurface boundary = subdivided(boundary_surface(problem.mesh), mesh);
    for (const VertexId v : boundary.vertex_ids) drawn.vertices.push_back(mesh.vertices[v]);
    drawn.triangles = boundary.triangles;
    embedding = embed(drawn.vertices, problem.mesh, threads);
  }
  drawn.tetrahedra.assign(embedding.tetrahedra.begin(), embedding.tetrahedra.end());
  drawn.weights = std::move(embedding.weights);
  return drawn;
}

// Adds the distances of the drawn surface; if that encloses nothing, a note instead.
void add_distances(const TetsOptions& options, TetsData& data, StageLog& log) {
  if (options.cells == 0) return;
  RenderSurface surface;
  surface.vertices = data.surface.vertices;
  surface.triangles = data.surface.triangles;
  log.begin("distances");
  const Result<ClosedSurface> closed = close_surface(surface, true, options.solid.threads);
  if (!closed) {
    log.note("bodies will not touch it: " + closed.error().message);
    return log.end("none");
  }
  const SurfaceDistance distance(*closed);
  const BoundingBox box = bounding_box(closed->surface.vertices);
  const double margin = kColliderMargin * (box.high - box.low).maxCoeff();
  data.nodes = unwrap(plan_nodes(box, options.cells, margin));
  data.distances = distances_at_nodes(distance, data.nodes, options.solid.threads);
  log.end(text("%u x %u x %u nodes, %.4g m apart", data.nodes.counts[0], data.nodes.counts[1],
               data.nodes.counts[2], data.nodes.spacing));
}

std::string tets_provenance(const TetsOptions& options, const Problem& problem) {
  TetsJson json;
  json["generator"] = std::string("tremolo-precompute ") + TREMOLO_VERSION;
  json["units"] = "SI";
  json["command_line"] = options.command_line;
  json["mesh"] = {{"file", std::filesystem::path(options.solid.files.mesh).filename().string()},
                  {"format", problem.mesh_format},
                  {"xxh3_64", problem.mesh_hash}};
  return json.dump(2, ' ', false, TetsJson::error_handler_t::replace);
}

TetsJson tets_json(const TetsOptions& options, const TetsData& data) {
  double volume = 0.0;
  for (const Tetrahedron& tet : data.mesh.tetrahedra) volume += signed_volume(data.mesh, tet);
  return {{"file", options.output_path},
          {"file_bytes", std::filesystem::file_size(options.output_path)},
          {"vertices", data.mesh.vertices.size()},
          {"elements", data.mesh.tetrahedra.size()},
          {"materials", data.materials.materials.size()},
          {"held", data.held.size()},
          {"volume", volume},
          {"drawn_vertices", data.surface.vertices.size()},
          {"drawn_triangles", data.surface.triangles.size()},
          {"grid_nodes", data.distances.size()}};
}

}  // namespace

void make_tets(const TetsOptions& options) {
  const std::vector<NamedFile> inputs = input_files(options.solid, options.config_path);
  unwrap(keep_apart({options.output_path}, inputs));
  const GuardedInputs guard(inputs);
  unwrap(AtomicFile::create(options.output_path));
  StageLog log(false);
  log.begin("mesh");
  const Problem problem = load_problem(options.solid);
  log.end(text("%zu tetrahedra, %zu vertices, %zu held", problem.mesh.tetrahedra.size(),
               problem.mesh.vertices.size(), problem.fixed.size()));
  for (const std::string& note : problem.notes) log.note(note);
  TetsData data;
  data.mesh.vertices = problem.mesh.vertices;
  data.mesh.tetrahedra = problem.mesh.tetrahedra;
  data.materials = problem.materials;
  data.held = problem.fixed;
  data.surface = drawn_surface(problem, options.solid.threads);
  add_distances(options, data, log);
  data.provenance = tets_provenance(options, problem);
  log.begin("file");
  unwrap(write_tets(options.output_path, data));
  log.end(options.output_path);
  if (options.json) print_json(tets_json(options, data));
  unwrap(flush_standard_output());
}

}  // namespace tremolo
