#include "precompute/provenance.h"

#include <filesystem>

#include <metis.h>
#include <nlohmann/json.hpp>

#include "formats/file/standard_streams.h"
#include "precompute/problem/material_rules.h"
#include "precompute/system/petsc.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

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
                            const PrecomputeResult& result) {
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
