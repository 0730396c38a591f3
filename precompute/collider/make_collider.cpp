#include "precompute/collider/make_collider.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/hash.h"
#include "common/mesh/mesh_check.h"
#include "common/mesh/surface_mesh.h"
#include "common/stage_log.h"
#include "common/text.h"
#include "common/units.h"
#include "formats/collider/collider_file.h"
#include "formats/file/atomic_file.h"
#include "formats/file/output_guard.h"
#include "formats/file/standard_streams.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/surface/surface_reader.h"
#include "precompute/collider/closed_surface.h"
#include "precompute/collider/collider_grid.h"
#include "precompute/collider/surface_distance.h"
#include "precompute/problem/up_axis.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using ColliderJson = nlohmann::ordered_json;

// The boundary of a tetrahedral mesh as if it were a surface file.
SurfaceFile read_boundary(const ColliderOptions& options) {
  MeshFile read = unwrap(read_tet_mesh(options.surface_path));
  const Result<MeshReport> report = check_mesh(read.mesh);
  if (!report) throw Failure(error_of_file(options.surface_path, report.error()));
  SurfaceFile file;
  const SurfaceMesh boundary = boundary_mesh(read.mesh);
  file.surface.vertices = boundary.vertices;
  file.surface.triangles = boundary.triangles;
  file.format = read.format + ", its boundary";
  file.unit = options.unit.empty() ? "metres (by default)" : options.unit + ", given";
  if (!options.unit.empty()) file.metres_per_unit = unwrap(metres_per_unit(options.unit));
  for (Eigen::Vector3d& x : file.surface.vertices) x *= file.metres_per_unit;
  file.notes = std::move(read.notes);
  return file;
}

SurfaceFile read_any_surface(const ColliderOptions& options) {
  if (!is_surface_file(options.surface_path)) return read_boundary(options);
  SurfaceReadOptions reading;
  if (!options.unit.empty()) reading.metres_per_unit = unwrap(metres_per_unit(options.unit));
  return unwrap(read_surface(options.surface_path, reading));
}

// A grid and its accuracy.
struct MadeGrid {
  int cells = 0;
  double margin = 0;  // m
  ColliderData data;
  GridError error;
  double missed = 0;  // fraction of the surface
  double seconds = 0;
};

double longest_side(const BoundingBox& box) {
  return (box.high - box.low).maxCoeff();
}

MadeGrid make_grid(const ColliderOptions& options, const SurfaceDistance& surface,
                   const BoundingBox& box, int cells) {
  const auto start = std::chrono::steady_clock::now();
  MadeGrid made;
  made.cells = cells;
  made.margin = options.margin.value_or(kColliderMargin * longest_side(box));
  made.data.nodes = unwrap(plan_nodes(box, cells, made.margin));
  made.margin = std::max(made.margin, kLeastMarginCells * made.data.nodes.spacing);
  made.data.distances = distances_at_nodes(surface, made.data.nodes, options.threads);
  if (std::none_of(made.data.distances.begin(), made.data.distances.end(),
                   [](float d) { return d < 0.0F; }))
    throw Failure(
        content_error(text("no node of the grid is inside: everything is thinner than its "
                           "cells of %.3g m; give more --cells than %d",
                           made.data.nodes.spacing, cells)));
  const DistanceGrid grid = unwrap(DistanceGrid::create(made.data.nodes, made.data.distances));
  made.error = measure_error(surface, grid, options.threads);
  made.missed = missed_share(surface, grid, options.threads);
  made.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return made;
}

bool is_good(const MadeGrid& made, double size) {
  return made.error.largest <= kColliderError * size && made.missed <= kColliderMissed;
}

// Without --cells: half as many again until the grid is good enough, or kLastCells are reached,
// or a grid may have no more.
MadeGrid make_grid_to_error(const ColliderOptions& options, const SurfaceDistance& surface,
                            const BoundingBox& box, StageLog& log) {
  if (options.cells) return make_grid(options, surface, box, *options.cells);
  const double margin = options.margin.value_or(kColliderMargin * longest_side(box));
  for (int cells = kFirstCells;;) {
    const int next = std::min(cells + cells / 2, kLastCells);
    const bool last = cells == kLastCells || !plan_nodes(box, next, margin);
    try {
      MadeGrid made = make_grid(options, surface, box, cells);
      if (last || is_good(made, longest_side(box))) return made;
      log.note(text("%d cells: the error is %.2g %% of the size, %.2g %% of the surface is missed",
                    cells, 100.0 * made.error.largest / longest_side(box), 100.0 * made.missed));
    } catch (const Failure&) {
      if (last) throw;  // too thin for these cells
    }
    cells = next;
  }
}

ColliderJson list_of(const Eigen::Vector3d& v) {
  return ColliderJson::array({v[0], v[1], v[2]});
}

ColliderJson surface_json(const ColliderOptions& options, const SurfaceFile& file,
                          const ClosedSurface& closed, const BoundingBox& box) {
  return {{"surface", options.surface_path},
          {"format", file.format},
          {"unit", file.unit},
          {"metres_per_unit", file.metres_per_unit},
          {"vertices", closed.surface.vertices.size()},
          {"triangles", closed.surface.triangles.size()},
          {"parts", closed.parts},
          {"turned_triangles", closed.turned_triangles},
          {"turned_parts", closed.turned_parts},
          {"holes_closed", closed.holes},
          {"largest_hole", closed.largest_hole},
          {"buried_triangles", closed.buried_triangles},
          {"low", list_of(box.low)},
          {"high", list_of(box.high)},
          {"size", longest_side(box)}};
}

ColliderJson grid_json(const MadeGrid& made, double size) {
  const GridNodes& nodes = made.data.nodes;
  return {{"cells", made.cells},
          {"nodes", {nodes.counts[0], nodes.counts[1], nodes.counts[2]}},
          {"spacing", nodes.spacing},
          {"margin", made.margin},
          {"memory", nodes.size() * sizeof(float)},
          {"error_max", made.error.largest},
          {"error_max_share", made.error.largest / size},
          {"error_rms", made.error.root_mean_square},
          {"error_points", made.error.points},
          {"missed_share", made.missed}};
}

std::string provenance_of(const ColliderOptions& options, const SurfaceFile& file,
                          const ClosedSurface& closed, ColliderJson grid) {
  ColliderJson json;
  json["generator"] = std::string("tremolo-precompute ") + TREMOLO_VERSION;
  json["units"] = "SI";
  json["command_line"] = options.command_line;
  json["surface"] = {
      {"file", std::filesystem::path(options.surface_path).filename().string()},
      {"format", file.format},
      {"vertices", closed.surface.vertices.size()},
      {"triangles", closed.surface.triangles.size()},
      {"xxh3_64", hash_text(hash_bytes(std::as_bytes(std::span(closed.surface.vertices))))}};
  json["grid"] = std::move(grid);
  return json.dump(2, ' ', false, ColliderJson::error_handler_t::replace);
}

void log_grid(const MadeGrid& made, double size, StageLog& log) {
  const GridNodes& nodes = made.data.nodes;
  log.end(text("%d cells of %.4g m, %u x %u x %u nodes, margin %.3g m, %.3g MB", made.cells,
               nodes.spacing, nodes.counts[0], nodes.counts[1], nodes.counts[2], made.margin,
               1e-6 * static_cast<double>(nodes.size() * sizeof(float))));
  log.note(
      text("largest error at %zu points near the surface: %.3g m, %.2g %% of the size %.4g m; "
           "root mean square %.2g m",
           made.error.points, made.error.largest, 100.0 * made.error.largest / size, size,
           made.error.root_mean_square));
  if (made.missed > 0.0)
    log.note(
        text("%sbehind %.2g %% of the surface the solid is too thin for these cells and missed",
             made.missed > kColliderMissed ? "warning: " : "", 100.0 * made.missed));
  if (!is_good(made, size)) log.note("more --cells make that smaller");
}

void make_file(const ColliderOptions& options) {
  StageLog log(false);
  log.begin("surface");
  SurfaceFile file = read_any_surface(options);
  if (options.y_up) turn_y_to_z(file.surface);
  const ClosedSurface closed =
      unwrap(close_surface(file.surface, options.fill_holes, options.threads));
  const BoundingBox box = bounding_box(closed.surface.vertices);
  log.end(text("%s, unit: %s, %zu triangles", file.format.c_str(), file.unit.c_str(),
               closed.surface.triangles.size()));
  for (const std::string& note : file.notes) log.note(note);
  for (const std::string& note : closed.notes) log.note(note);

  log.begin("distances");
  const SurfaceDistance surface(closed);
  MadeGrid made = make_grid_to_error(options, surface, box, log);
  const double size = longest_side(box);
  log_grid(made, size, log);

  log.begin("file");
  ColliderJson grid = grid_json(made, size);
  made.data.provenance = provenance_of(options, file, closed, grid);
  unwrap(write_collider(options.output_path, made.data));
  log.end(options.output_path);
  if (options.json) {
    ColliderJson json = surface_json(options, file, closed, box);
    json.update(grid);
    json["seconds"] = made.seconds;
    json["file"] = options.output_path;
    json["file_bytes"] = std::filesystem::file_size(options.output_path);
    print_json(json);
  }
  unwrap(flush_standard_output());
}

}  // namespace

void make_collider(const ColliderOptions& options) {
  const std::vector<NamedFile> inputs = {{options.surface_path, "the surface", true}};
  unwrap(keep_apart({options.output_path}, inputs));
  const GuardedInputs guard(inputs);
  unwrap(AtomicFile::create(options.output_path));
  try {
    make_file(options);
  } catch (const Failure& failure) {
    const bool of_output = failure.error().kind != ErrorKind::kContent;
    throw of_output ? failure : Failure(error_of_file(options.surface_path, failure.error()));
  }
}

}  // namespace tremolo
