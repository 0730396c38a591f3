// Where a basis file comes from, as JSON. Nothing that changes from run to run.
#include <filesystem>

#include <metis.h>
#include <nlohmann/json.hpp>

#include "precompute/petsc.h"
#include "precompute/pipeline.h"

namespace tremolo {
namespace {

std::string version_of(int major, int minor, int subminor) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(subminor);
}

}  // namespace

std::string provenance_json(const PrecomputeOptions& options, const PrecomputeResult& result) {
  using Json = nlohmann::ordered_json;
  const PrecomputeFindings& findings = result.findings;
  const auto r = static_cast<std::size_t>(result.data.lambda.size());
  Json json;
  json["generator"] = std::string("tremolo-precompute ") + TREMOLO_VERSION;
  json["units"] = "SI";
  json["command_line"] = options.command_line;
  json["mesh"] = {{"file", std::filesystem::path(options.mesh_path).filename().string()},
                  {"format", result.problem.mesh_format},
                  {"xxh3_64", result.problem.mesh_hash}};
  json["material"] = {{"model", "St. Venant-Kirchhoff"},
                      {"young_pa", options.material.young},
                      {"poisson", options.material.poisson},
                      {"density_kg_m3", options.material.density}};
  if (const auto& render = result.problem.render) {
    const Embedding& embedding = result.problem.embedding;
    const std::string& path = options.render_path.empty() ? options.mesh_path : options.render_path;
    json["render"] = {{"file", std::filesystem::path(path).filename().string()},
                      {"vertices", render->vertices.size()},
                      {"triangles", render->triangles.size()},
                      {"outside", embedding.outside},
                      {"largest_distance_m", embedding.largest_distance},
                      {"clamped", embedding.clamped}};
  }
  json["mass"] = options.mass == MassKind::kConsistent ? "consistent" : "lumped";
  json["fix"] = options.fix;
  json["modes"] = {{"solver", findings.mode_solver},
                   {"factorisation", findings.factorisation},
                   {"residuals", findings.mode_residuals},
                   {"certified_by_inertia", findings.certified}};
  json["derivative_residual"] = findings.derivative_residual;
  json["mass_orthonormality_error"] = findings.orthonormality_error;
  json["stiffness_diagonality_error"] = findings.diagonality_error;
  json["polynomial_error"] = findings.polynomial_error;
  const auto& sigma = result.data.singular_values;
  json["singular_value_cut"] = r < sigma.size() ? Json(sigma[r] / sigma[0]) : Json(nullptr);
  if (findings.encoding_error)
    json["encoding"] = {{"name", "compact"},
                        {"displacement_error", findings.encoding_error->displacement},
                        {"displacement_error_bound", findings.encoding_error->displacement_bound},
                        {"force_error", findings.encoding_error->force}};
  json["versions"] = {
      {"petsc", version_of(PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
      {"slepc", version_of(SLEPC_VERSION_MAJOR, SLEPC_VERSION_MINOR, SLEPC_VERSION_SUBMINOR)},
      {"metis", version_of(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)}};
  // A file name need not be UTF-8; the provenance is.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tremolo
