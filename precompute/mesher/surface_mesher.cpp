#include "precompute/mesher/surface_mesher.h"

#include <algorithm>
#include <cmath>

#include "common/text.h"
#include "common/units.h"
#include "formats/surface/surface_reader.h"
#include "precompute/mesher/surface/mesh_likeness.h"
#include "precompute/mesher/surface/surface_solid.h"
#include "precompute/mesher/surface_plan.h"

namespace tremolo {
namespace {

// Shares of the solid angle: a surface that lacks more is closed only on demand, or is a sheet.
constexpr double kMostLacking = 0.09, kSheet = 0.4;
// The solid is behind at least this fraction of its surface.
constexpr double kLeastBacked = 0.3;
// Further attempts if a mesh does not follow its surface and the user requested no size.
constexpr int kRefinements = 2;
// The size that a message advises, over the thickness of the walls.
constexpr double kSizePerWall = 3;
// A distance between the surfaces so many times that requested is reported: the largest of 20 000
// points is no sharp number.
constexpr double kMissedError = 1.1;

// Refuses a surface that encloses no solid, and says what its maker can do.
Status refuse_hopeless(const SurfaceSolid& solid, const SurfaceFindings& findings,
                       const SurfaceMeshOptions& options, const Scaling& scaling) {
  if (solid.half_thickness > 0) return Success{};
  const std::string thicken =
      text("If it is a sheet, give it a thickness by --thicken, say --thicken %.2g (m)",
           0.02 * scaling.diagonal);
  const Openness open = openness(solid);
  if (open.lacking <= kMostLacking && open.backed >= kLeastBacked) return Success{};
  if (findings.one_sided_edges > 0)
    return content_error("the surface is one-sided, like a Moebius strip: it has no inside. " +
                         thicken);
  if (open.backed < kLeastBacked || (open.lacking > kSheet && !options.fill_holes))
    return content_error("the surface encloses no volume. " + thicken);
  if (options.fill_holes) return Success{};
  if (findings.holes == 0)
    return content_error(
        "the surface runs through itself so that much of it faces inwards. Take "
        "its parts apart in the modelling program, or mesh where the solid angle "
        "says inside, by --fill-holes. " +
        thicken);
  return content_error(text("the surface is open: its holes (%zu) are %.0f %% of its area. Close "
                            "them in the modelling program, or by --fill-holes. ",
                            findings.holes, 100.0 * findings.hole_share) +
                       thicken);
}

// The error when no method of meshing succeeds, and what the maker of the surface can do.
Error no_end(const Error& error, const SurfaceSolid& solid, const SurfaceFindings& findings) {
  if (solid.half_thickness > 0 || findings.holes == 0)
    return {error.kind, error.message +
                            ". Ask for larger tetrahedra by --size or --tets, or clean the surface "
                            "in a modelling program"};
  return content_error(
      text("%s where the surface is open: its holes (%zu) are %.2g %% of its "
           "area, and the solid is too thin there for its border to be guessed. "
           "Close them in the modelling program, or ask for larger tetrahedra by "
           "--size or --tets",
           error.message.c_str(), findings.holes, 100.0 * findings.hole_share));
}

// A mesh before it is scaled back to metres.
struct Outcome {
  MeshAttempt attempt;
  PartCounts parts;
  Likeness likeness;
  SurfaceDistances distances;
};

// The error when the mesher loses the walls, as `what` says, and what their maker can do. asked:
// the user requested the sizes.
Error walls_are_lost(std::string what, const MeshPlan& plan, bool asked, double diagonal) {
  const double wall = median_thickness(plan);
  if (!(wall > 0)) return content_error(what + ". Ask for smaller tetrahedra by --size or --tets");
  double size = kSizePerWall * wall;
  if (asked) size = std::min(size, 0.5 * plan.coarse);
  const double count = estimated_count(plan.walls, plan.volume, size, 0.25 * size);
  return content_error(
      what + text(": its walls are about %.3g m thick at a size of %.3g m. Make them thicker, or "
                  "ask for smaller tetrahedra, say by --size %.2g (some %.1g of them), or for more "
                  "by --tets",
                  wall * diagonal, diagonal, size * diagonal, count));
}

std::string describe(const Likeness& likeness) {
  return text(
      "the mesh that came out has %.2g %% of the volume of the surface, in %zu part%s where "
      "the surface has %zu",
      100.0 * likeness.volume_share, likeness.parts, likeness.parts == 1 ? "" : "s",
      likeness.most_parts);
}

// Meshes by the plan, and by smaller sizes if the user requested none and the surfaces are too far
// apart.
Result<Outcome> mesh_close_to_surface(const SurfaceSolid& solid, const SurfaceFindings& findings,
                                      MeshPlan plan, const SurfaceMeshOptions& options,
                                      double diagonal) {
  const bool asked = options.size > 0 || options.tets > 0 || options.error > 0;
  for (int pass = 0;; ++pass) {
    Result<MeshAttempt> done = attempt_mesh_to_count(solid, plan, options.tets);
    if (!done) return no_end(done.error(), solid, findings);
    if (done->mesh.tetrahedra.empty())
      return walls_are_lost("no mesh came out, since the solid is thinner than the size", plan,
                            asked, diagonal);
    Outcome outcome;
    outcome.likeness = compare_with_solid(solid, plan.volume, done->mesh);
    outcome.parts = drop_crumbs(done->mesh, options.keep_crumbs);
    outcome.likeness.parts = outcome.parts.kept;
    const bool lost = outcome.likeness.is_lost();
    if (lost && (asked || pass > 0 || has_thin_walls(plan)))
      return walls_are_lost(describe(outcome.likeness), plan, asked, diagonal);
    outcome.distances = measure_distances(solid, plan.error, done->mesh);
    outcome.attempt = std::move(*done);
    const bool far = outcome.distances.mesh_to_surface > kWorstError;
    if (!lost && (asked || !far || pass == kRefinements)) return outcome;
    plan.error *= 0.6;
    plan.coarse *= 0.75;
    plan.fine *= 0.75;
  }
}

// Number by number: cast<float>().cast<double>() of Eigen 3.4 leaves vectors of three unrounded.
double nearest_float(double x) {
  return static_cast<double>(static_cast<float>(x));
}

// What the user must know about masses and distances before using the mesh; lengths in m.
std::vector<std::string> warnings_on(const Outcome& outcome, const SurfaceMeshOptions& options,
                                     double diagonal) {
  std::vector<std::string> warnings;
  const double off = outcome.likeness.volume_share - 1.0;
  const double far =
      diagonal * std::max(outcome.distances.mesh_to_surface, outcome.distances.surface_to_mesh);
  if (outcome.likeness.is_poor())
    warnings.push_back(
        text("warning: the mesh has %.2g %% %s volume than the surface, so masses and frequencies "
             "are off: ask for a smaller distance by --error (it is %.2g m), or for smaller "
             "tetrahedra by --size or --tets",
             100.0 * std::abs(off), off < 0 ? "less" : "more", far));
  if (options.error > 0 && far > kMissedError * options.error)
    warnings.push_back(text(
        "warning: the surfaces are up to %.3g m apart, where --error asked for %.3g m: smaller "
        "tetrahedra help (--size or --tets), or a smaller --error",
        far, options.error));
  return warnings;
}

// Notes about the mesh for the user, as sentences.
std::vector<std::string> notes_on(const Outcome& outcome, const MeshQuality& quality,
                                  int wanted_count) {
  std::vector<std::string> notes;
  if (outcome.parts.dropped > 0)
    notes.push_back(
        text("%zu part%s of less than 1 %% of the largest one's volume left "
             "out; --keep-crumbs keeps them",
             outcome.parts.dropped, outcome.parts.dropped == 1 ? "" : "s"));
  if (outcome.parts.kept > 1)
    notes.push_back(
        text("%zu separate bodies: each must be held, or none (--fix none)", outcome.parts.kept));
  const double far = std::max(outcome.distances.mesh_to_surface, outcome.distances.surface_to_mesh);
  if (far > kWorstError)
    notes.push_back(
        text("the surfaces are up to %.2g %% of the diagonal apart: details below the size; more "
             "tetrahedra (--tets) help",
             100.0 * far));
  if (quality.min_dihedral_deg < kGoodAngle)
    notes.push_back(
        text("the smallest dihedral angle is %.2g degrees: thin walls or edges; "
             "more tetrahedra (--tets) help",
             quality.min_dihedral_deg));
  const std::size_t count = outcome.attempt.mesh.tetrahedra.size();
  const double share = static_cast<double>(count) / std::max(1, wanted_count);
  if (wanted_count > 0 && !is_met(share))
    notes.push_back(
        text("%d tetrahedra were asked for, %zu came out: thin walls, sharp "
             "edges and the wanted distance to the surface %s",
             wanted_count, count,
             share > 1 ? "ask for more (a larger --error takes fewer)"
                       : "do not lead to more in six tries"));
  return notes;
}

// The error for a surface all of whose triangles are flat, at the scale of its diagonal.
Error no_area(const RenderSurface& surface) {
  // A vertex is stray if the others are closer together than this, over its distance.
  constexpr double kStray = 1e-6;
  std::vector<VertexId> used;
  for (const Triangle& t : surface.triangles) used.insert(used.end(), t.begin(), t.end());
  const auto reach = [&](VertexId v) { return surface.vertices[v].cwiseAbs().maxCoeff(); };
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::sort(used.begin(), used.end(), [&](VertexId a, VertexId b) { return reach(a) < reach(b); });
  if (used.size() > 3) {
    const VertexId last = used.back();
    const double others = reach(used[used.size() / 2]);
    if (others > 0 && others < kStray * reach(last)) {
      const Eigen::Vector3d& x = surface.vertices[last];
      return content_error(
          text("vertex %d (from 0, in the file's order) is at (%.6g, %.6g, %.6g) m, where half of "
               "the others are within %.3g m of the origin: beside it no triangle has an area. "
               "Correct its coordinates",
               last, x[0], x[1], x[2], others));
    }
  }
  return content_error(
      "no triangle of the surface has an area: is it a drawing of points or lines? Export faces");
}

}  // namespace

Result<MeshedSurface> mesh_surface(const RenderSurface& given, const SurfaceMeshOptions& options) {
  Scaling scaling;
  RepairedSurface repaired = repair_surface(scale(given, scaling), given.object_of);
  if (repaired.mesh.triangles.empty()) return no_area(given);
  const SurfaceFindings findings = repaired.findings;
  std::vector<std::int32_t> turned;
  for (std::size_t t = 0; t < repaired.turned.size(); ++t)
    if (repaired.turned[t] != 0) turned.push_back(static_cast<std::int32_t>(t));
  const SurfaceSolid solid(std::move(repaired), options.thicken / scaling.diagonal);
  if (Status status = refuse_hopeless(solid, findings, options, scaling); !status)
    return status.error();
  const Result<MeshPlan> plan = make_plan(solid, options, scaling);
  if (!plan) return plan.error();
  Result<Outcome> outcome =
      mesh_close_to_surface(solid, findings, *plan, options, scaling.diagonal);
  if (!outcome) return outcome.error();

  TetMesh& mesh = outcome->attempt.mesh;
  for (Eigen::Vector3d& x : mesh.vertices) x = scaling.out(x);
  SurfaceMeshReport report;
  report.findings = findings;
  report.method = outcome->attempt.method;
  report.quality = mesh_quality(mesh);
  report.notes = notes_on(*outcome, report.quality, options.tets);
  for (std::string& warning : warnings_on(*outcome, options, scaling.diagonal))
    report.notes.push_back(std::move(warning));
  report.tetrahedra = mesh.tetrahedra.size();
  report.diagonal = scaling.diagonal;
  report.mesh_to_surface = scaling.diagonal * outcome->distances.mesh_to_surface;
  report.surface_to_mesh = scaling.diagonal * outcome->distances.surface_to_mesh;
  report.cap_to_surface = scaling.diagonal * outcome->distances.cap_to_surface;
  return MeshedSurface{std::move(mesh), std::move(report), std::move(turned)};
}

void restore_printed_floats(std::vector<Eigen::Vector3d>& vertices, double metres_per_unit) {
  double largest = 0, moved = 0;
  for (const Eigen::Vector3d& x : vertices) {
    const Eigen::Vector3d number = x / metres_per_unit;
    largest = std::max(largest, number.cwiseAbs().maxCoeff());
    moved = std::max(moved, (number - number.unaryExpr(&nearest_float)).cwiseAbs().maxCoeff());
  }
  // Floats near the largest are 2^-24 of it or more apart, so numbers that never were floats are
  // 2^-26 of it from them in the mean. That all are within half of that is no chance.
  if (!(moved <= std::ldexp(largest, -27))) return;
  for (Eigen::Vector3d& x : vertices)
    x = metres_per_unit * (x / metres_per_unit).unaryExpr(&nearest_float);
}

std::vector<std::string> describe(const SurfaceMeshReport& report) {
  std::vector<std::string> lines = describe(report.findings);
  lines.push_back(std::string(report.findings.clean() ? "closed and without crossings: " : "") +
                  "meshed " + report.method);
  lines.insert(lines.end(), report.notes.begin(), report.notes.end());
  const MeshQuality& quality = report.quality;
  lines.push_back(text("%zu tetrahedra, dihedral angles %.1f to %.1f degrees, %.4g m^3",
                       report.tetrahedra, quality.min_dihedral_deg, quality.max_dihedral_deg,
                       quality.volume));
  lines.push_back(
      text("mesh to surface at most %.3g m (%.2g %% of the diagonal), surface to mesh "
           "%.3g m (%.2g %%)",
           report.mesh_to_surface, 100.0 * report.mesh_to_surface / report.diagonal,
           report.surface_to_mesh, 100.0 * report.surface_to_mesh / report.diagonal));
  return lines;
}

Result<MesherAnswer> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options) {
  SurfaceReadOptions reading;
  if (!unit.empty()) {
    const Result<double> metres = metres_per_unit(unit);
    if (!metres) return metres.error();
    reading.metres_per_unit = *metres;
  }
  Result<SurfaceFile> file = read_surface(path, reading);
  if (!file) return file.error();
  RenderSurface& surface = file->surface;
  restore_printed_floats(surface.vertices, file->metres_per_unit);
  Result<MeshedSurface> meshed = mesh_surface(surface, options);
  if (!meshed) return Error{meshed.error().kind, path + ": " + meshed.error().message};
  MesherAnswer answer{std::move(meshed->mesh), file->format, {}, std::move(meshed->turned)};
  answer.notes.push_back(
      file->format +
      text(": a surface of %zu vertices and %zu triangles in %zu object%s, %.4g m across; unit: ",
           surface.vertices.size(), surface.triangles.size(), surface.objects.size(),
           surface.objects.size() == 1 ? "" : "s", meshed->report.diagonal) +
      file->unit);
  answer.notes.insert(answer.notes.end(), file->notes.begin(), file->notes.end());
  const std::vector<std::string> lines = describe(meshed->report);
  answer.notes.insert(answer.notes.end(), lines.begin(), lines.end());
  return answer;
}

}  // namespace tremolo
