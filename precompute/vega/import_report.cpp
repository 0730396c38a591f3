// JSON of an imported model: its provenance and the report of --json.
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "common/units.h"
#include "formats/file/standard_streams.h"
#include "precompute/vega/import.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json import_json(const ImportFindings& findings) {
  return {{"mass", findings.mass == MassKind::kLumped ? "lumped" : "consistent"},
          {"orthonormalised", findings.orthonormalised},
          {"lumped_orthonormality_error", findings.lumped_error},
          {"consistent_orthonormality_error", findings.consistent_error},
          {"asymmetry", findings.asymmetry},
          {"force_error", findings.force_error}};
}

Json encoding_json(const ImportFindings& findings) {
  if (!findings.encoding_error) return {{"name", "full"}};
  return {{"name", "compact"},
          {"displacement_error", findings.encoding_error->displacement},
          {"displacement_error_bound", findings.encoding_error->displacement_bound},
          {"force_error", findings.encoding_error->force}};
}

}  // namespace

std::string import_provenance(const ImportRequest& request, const ImportResult& result) {
  const ImportFindings& findings = result.findings;
  const auto name = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  Json json;
  json["generator"] = std::string("tremolo-precompute ") + TREMOLO_VERSION;
  json["units"] = "SI";
  json["command_line"] = request.output.command_line;
  json["mesh"] = {{"file", name(request.solid.files.mesh)},
                  {"format", result.problem.mesh_format},
                  {"xxh3_64", result.problem.mesh_hash}};
  // Only the densities of the materials are used; the stiffness comes from the .cub.
  Json densities = Json::array();
  for (const NamedMaterial& named : result.problem.materials.materials)
    densities.push_back({{"name", named.name}, {"density_kg_m3", named.material.density}});
  json["materials"] = densities;
  json["mass"] = findings.mass == MassKind::kLumped ? "lumped" : "consistent";
  json["fix"] = texts_of(request.solid.support.fixed);
  json["import"] = import_json(findings);
  json["import"]["basis"] = {{"file", name(request.basis_path)}, {"xxh3_64", findings.basis_hash}};
  json["import"]["cubic"] = {{"file", name(request.cubic_path)}, {"xxh3_64", findings.cubic_hash}};
  json["mass_orthonormality_error"] = findings.orthonormality_error;
  if (findings.encoding_error) json["encoding"] = encoding_json(findings);
  return json_text(json);
}

std::string import_report(const ImportResult& result) {
  const BasisData& data = result.data;
  Json frequencies = Json::array();
  for (double value : data.lambda) frequencies.push_back(hertz(value));
  return json_text(
      Json{{"n", data.vertex_count},
           {"m", data.tetrahedron_count},
           {"r", data.lambda.size()},
           {"fixed_vertices", data.fixed_vertex_count},
           {"rigid_modes", data.rigid_mode_count},
           {"frequencies_hz", frequencies},
           {"explicit_step_limit_s", 2.0 / std::sqrt(data.lambda[data.lambda.size() - 1])},
           {"total_mass_kg", data.total_mass},
           {"mass_orthonormality_error", result.findings.orthonormality_error},
           {"import", import_json(result.findings)},
           {"encoding", encoding_json(result.findings)},
           {"notes", result.problem.notes}});
}

}  // namespace tremolo
