#include "precompute/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <metis.h>
#include <nlohmann/json.hpp>

#include "common/units.h"
#include "formats/file/standard_streams.h"
#include "formats/vtk/vtu_writer.h"
#include "precompute/fit_solid.h"
#include "precompute/problem/material_rules.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json stages_json(const StageLog& log) {
  Json stages = Json::array();
  for (const StageRecord& stage : log.records())
    stages.push_back({{"name", stage.name},
                      {"seconds", stage.seconds},
                      {"cpu_seconds", stage.cpu_seconds},
                      {"limit_seconds", stage.limit_seconds},
                      {"limit_reason", stage.limit_reason},
                      {"peak_bytes", stage.peak_bytes},
                      {"detail", stage.detail}});
  return stages;
}

Json ranks_json(const RankTable& ranks) {
  Json rows = Json::array();
  for (const RankTable::Row& row : ranks.rows)
    rows.push_back({{"stage", row.stage},
                    {"seconds", row.seconds},
                    {"cpu_seconds", row.cpu_seconds},
                    {"peak_bytes", row.peak_bytes}});
  return rows;
}

// Returns one material or several, as stored in the provenance.
Json materials_json(const Json& provenance) {
  Json materials = Json::array();
  if (provenance.contains("materials")) materials = provenance["materials"];
  if (provenance.contains("material")) materials.push_back(provenance["material"]);
  return materials;
}

// Returns the largest stable step of an explicit method, s.
double explicit_step_limit(const BasisData& data) {
  return 2.0 / std::sqrt(data.lambda[data.lambda.size() - 1]);
}

// Returns the rows of U in the order of the mesh's vertices.
BasisRows rows_of_mesh(const BasisData& data) {
  BasisRows rows(3 * static_cast<Eigen::Index>(data.vertex_count), data.lambda.size());
  for (const VertexBlock* block : {&data.surface, &data.interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      rows.middleRows(3 * Eigen::Index{block->vertex_ids[i]}, 3) =
          block->rows.middleRows(3 * static_cast<Eigen::Index>(i), 3);
  return rows;
}

}  // namespace

void write_vtu(const std::string& path, const TetMesh& mesh, const BasisData& data, StageLog& log) {
  if (path.empty()) return;
  log.begin("vtu");
  const BasisRows rows = rows_of_mesh(data);
  if (mesh.edges.empty())
    unwrap(write_modes_vtu(path, mesh.vertices, std::span<const Tetrahedron>(mesh.tetrahedra), rows,
                           data.lambda));
  else
    unwrap(write_modes_vtu(path, mesh.vertices,
                           std::span<const QuadraticCell>(quadratic_cells(mesh)), rows,
                           data.lambda));
  log.end(path);
}

void print_result(const LoadedProblem& loaded, const PrecomputeResult& result, const SolidFit* fit,
                  const StageLog& log, const RankTable& ranks) {
  const BasisData& data = result.data;
  const std::size_t r = data.lambda.size();
  Json frequencies = Json::array();
  for (double value : data.lambda) frequencies.push_back(hertz(value));
  std::vector<double> cut(data.singular_values.begin() +
                              static_cast<std::ptrdiff_t>(std::min(r, data.singular_values.size())),
                          data.singular_values.end());
  std::vector<std::string> notes = loaded.problem.notes;
  notes.insert(notes.end(), result.findings.notes.begin(), result.findings.notes.end());
  const std::string_view warns = "warning: ";
  std::vector<std::string> warnings, logged = notes;
  for (const std::string& note : describe(loaded.locking)) logged.push_back(note);
  logged.push_back(note_on_rigid_motions(loaded.rigid_motions()));
  for (const std::string& note : logged)
    if (note.starts_with(warns)) warnings.push_back(note.substr(warns.size()));
  const Json provenance = Json::parse(data.provenance);
  const auto& sensitivities = result.findings.sensitivities;
  const Json json = {
      {"order", loaded.problem.order},
      {"elements", data.tetrahedron_count},
      {"dofs", 3 * loaded.map.nodes()},
      {"n", data.vertex_count},
      {"m", data.tetrahedron_count},
      {"r", r},
      {"linear_modes", data.linear_mode_count},
      {"rigid_modes", data.rigid_mode_count},
      {"frequencies_hz", frequencies},
      {"explicit_step_limit_s", explicit_step_limit(data)},
      {"total_mass_kg", data.total_mass},
      {"materials", materials_json(provenance)},
      {"point_masses", provenance.value("point_masses", Json::array())},
      {"factorisation", result.findings.factorisation},
      {"mode_residuals", result.findings.mode_residuals},
      {"derivative_residual", result.findings.derivative_residual},
      {"inertia_count", result.findings.inertia_count},
      {"certified_by_inertia", result.findings.certified},
      {"mass_orthonormality_error", result.findings.orthonormality_error},
      {"polynomial_error", result.findings.polynomial_error},
      {"cut_singular_values", cut},
      {"locking", to_json(loaded.locking)},
      {"target_error", target_json(result.findings.target)},
      {"error_budget", budget_json(result.findings.budget)},
      {"fit", fit != nullptr ? fit_json(*fit) : Json(nullptr)},
      {"sensitivities", sensitivities ? sensitivities_json(*sensitivities, loaded.problem.materials)
                                      : Json(nullptr)},
      {"encoding", provenance.value("encoding", Json{{"name", "full"}})},
      {"notes", notes},
      {"warnings", warnings},
      {"ranks", mpi_ranks()},
      {"stages", stages_json(log)},
      {"stages_of_ranks", ranks_json(ranks)}};
  print_json(json);
}

void print_spectrum(const BasisData& data) {
  std::fprintf(stderr, "  frequencies ");
  for (double value : data.lambda) std::fprintf(stderr, " %.4g", hertz(value));
  std::fprintf(stderr, " Hz\n  explicit methods are stable below a step of %.4g s\n",
               explicit_step_limit(data));
}

void print_total(const StageLog& log, const RankTable& ranks) {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak = 0;
  for (const StageRecord& stage : log.records()) {
    seconds += stage.seconds;
    cpu_seconds += stage.cpu_seconds;
    peak = std::max(peak, stage.peak_bytes);
  }
  std::fprintf(stderr, "  %-12s %7.2f s %7.2f s cpu %6.0f MB\n", "total", seconds, cpu_seconds,
               static_cast<double>(peak) / 1e6);
  if (mpi_ranks() > 1)
    std::fprintf(stderr, "  processor time and peak memory of each rank\n%s\n",
                 table_text(ranks).c_str());
}

namespace {

Json material_json(const Material& material) {
  Json json{{"model", "St. Venant-Kirchhoff"}};
  if (!material.orthotropic) {
    json["young_pa"] = material.young;
    json["poisson"] = material.poisson;
  } else {
    const OrthotropicElasticity& o = *material.orthotropic;
    const auto list = [](const Eigen::Vector3d& v) { return Json::array({v[0], v[1], v[2]}); };
    json["model"] = "St. Venant-Kirchhoff, orthotropic";
    json["young_123_pa"] = list(o.young);
    json["poisson_12_23_31"] = list(o.poisson);
    json["shear_12_23_31_pa"] = list(o.shear);
    json["axes"] = Json::array({list(o.axes.col(0)), list(o.axes.col(1)), list(o.axes.col(2))});
  }
  json["density_kg_m3"] = material.density;
  return json;
}

// Adds `material` or, for several, `materials`; adds `point_masses` if there are any.
void add_materials(const Problem& problem, Json& json) {
  const MaterialTable& table = problem.materials;
  if (table.materials.size() == 1) {
    json["material"] = material_json(table.materials.front().material);
  } else {
    const std::vector<MaterialShare> shares = material_shares(table, problem.mesh);
    Json list = Json::array();
    for (std::size_t i = 0; i < shares.size(); ++i) {
      Json entry{{"region", table.materials[i].name},
                 {"tetrahedra", shares[i].tetrahedra},
                 {"volume_m3", shares[i].volume}};
      entry.update(material_json(table.materials[i].material));
      list.push_back(std::move(entry));
    }
    json["materials"] = std::move(list);
  }
  if (problem.point_masses.empty()) return;
  Json list = Json::array();
  for (const PointMass& mass : problem.point_masses)
    list.push_back({{"selector", mass.selector},
                    {"kg", mass.kilograms},
                    {"vertices", mass.vertices.size()},
                    {"fixed_vertices", mass.fixed}});
  json["point_masses"] = std::move(list);
}

}  // namespace

std::string provenance_json(const PrecomputeRequest& request, const Problem& problem,
                            const PrecomputeResult& result, const SolidFit* fit) {
  const PrecomputeFindings& findings = result.findings;
  const std::size_t r = result.data.lambda.size();
  Json json;
  json["generator"] = std::string("tremolo-precompute ") + TREMOLO_VERSION;
  json["units"] = "SI";
  json["command_line"] = request.output.command_line;
  json["mesh"] = {{"file", std::filesystem::path(request.solid.files.mesh).filename().string()},
                  {"format", problem.mesh_format},
                  {"xxh3_64", problem.mesh_hash}};
  add_materials(problem, json);
  if (const auto& render = problem.render) {
    const Embedding& embedding = problem.embedding;
    const SolidFiles& files = request.solid.files;
    const std::string& path = files.render.empty() ? files.mesh : files.render;
    json["render"] = {{"file", std::filesystem::path(path).filename().string()},
                      {"vertices", render->vertices.size()},
                      {"triangles", render->triangles.size()},
                      {"outside", embedding.outside},
                      {"largest_distance_m", embedding.largest_distance},
                      {"clamped", embedding.clamped}};
  }
  json["order"] = problem.order;
  json["mass"] = request.solid.elements.mass == MassKind::kConsistent ? "consistent" : "lumped";
  json["fix"] = texts_of(request.solid.support.fixed);
  json["modes"] = {{"solver", findings.mode_solver},
                   {"factorisation", findings.factorisation},
                   {"residuals", findings.mode_residuals},
                   {"certified_by_inertia", findings.certified}};
  if (!request.basis.linear) json["derivatives"] = request.basis.derivatives;
  if (fit != nullptr) json["fit"] = fit_json(*fit);
  json["derivative_residual"] = findings.derivative_residual;
  json["mass_orthonormality_error"] = findings.orthonormality_error;
  json["stiffness_diagonality_error"] = findings.diagonality_error;
  json["polynomial_error"] = findings.polynomial_error;
  const auto& sigma = result.data.singular_values;
  json["singular_value_cut"] = r < sigma.size() ? Json(sigma[r] / sigma[0]) : Json(nullptr);
  if (findings.target) {
    json["target_error"] = target_json(findings.target);
    json["target_error"].erase("measured");
  }
  if (findings.encoding_error)
    json["encoding"] = {{"name", "compact"},
                        {"displacement_error", findings.encoding_error->displacement},
                        {"displacement_error_bound", findings.encoding_error->displacement_bound},
                        {"force_error", findings.encoding_error->force}};
  json["versions"] = {
      {"petsc", petsc_version()},
      {"slepc", slepc_version()},
      {"metis", version_text(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)}};
  // A file name need not be UTF-8; the provenance is.
  return json_text(json);
}

}  // namespace tremolo
