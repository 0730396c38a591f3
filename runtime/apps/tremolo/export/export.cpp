#include "runtime/apps/tremolo/export/export.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/derived_basis.h"
#include "formats/file/atomic_file.h"
#include "formats/file/output_guard.h"
#include "formats/vega/reduced_files.h"
#include "formats/vtk/vtu_writer.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_body.h"

namespace tremolo {
namespace {

Status check_outputs(const ExportOptions& options) {
  if (!options.any())
    return Error{ErrorKind::kUsage,
                 "nothing to export: name an output with --glb, --page, --pc2, --mdd, --pvd, "
                 "--usda, --series, --cub, --U, --vtu, --light or --rescaled"};
  if (!options.rescaled.empty() && options.rescale.empty())
    return usage_error("--rescaled is the file of a model that --rescale changes: say which");
  const std::vector<std::string> outputs = {options.cub, options.u, options.vtu, options.light,
                                            options.rescaled};
  if (Status s = keep_apart(outputs, {{options.model, "the basis file"}}); !s) return s;
  return check_writable(outputs);
}

// The rows of the mesh's vertices; edge points of quadratic elements are left out, VegaFEM's meshes
// having none.
Result<Eigen::MatrixXd> whole_basis(const BasisData& data) {
  if (data.surface.vertex_ids.size() + data.interior.vertex_ids.size() != data.vertex_count)
    return content_error("the file has no rows of the vertices inside");
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(3 * data.vertex_count, data.lambda.size());
  for (const VertexBlock* block : {&data.surface, &data.interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      basis.middleRows(3 * Eigen::Index{block->vertex_ids[i]}, 3) =
          block->rows.middleRows(3 * i, 3);
  if (data.edges.empty()) return basis;
  Eigen::Index kept = 0;
  auto edge = data.edges.begin();
  for (VertexId v = 0; std::cmp_less(v, data.vertex_count); ++v) {
    if (edge != data.edges.end() && edge->point == v) {
      ++edge;
      continue;
    }
    basis.middleRows(3 * kept, 3) = basis.middleRows(3 * Eigen::Index{v}, 3).eval();
    ++kept;
  }
  return Eigen::MatrixXd(basis.topRows(3 * kept));
}

Result<std::string> make_cub(const BasisData& data) {
  // The limit of r for a .cub is checked here, before the work.
  if (data.lambda.size() > 336)
    return cub_bytes({static_cast<std::size_t>(data.lambda.size()), {}, {}, {}});
  return cub_bytes(reduced_forces(data.lambda, data.cubic, data.quartic));
}

Result<std::string> make_u(const BasisData& data) {
  const Result<Eigen::MatrixXd> basis = whole_basis(data);
  if (!basis) return basis.error();
  return basis_matrix_bytes(*basis);
}

// Which mass the basis is orthonormal in, as the file's maker says.
std::string mass_of(const BasisData& data) {
  const auto json = nlohmann::json::parse(data.provenance, nullptr, false);
  return json.is_object() && json.contains("mass") && json["mass"].is_string()
             ? json["mass"].get<std::string>()
             : std::string();
}

void note_basis(const BasisData& data, bool compact) {
  const std::string mass = mass_of(data);
  if (mass != "lumped")
    tell(
        "  note: the basis is orthonormal in the {}, VegaFEM's in the lumped one: its solvers want "
        "the reduced mass U^T M U, or a model made with --mass lumped\n",
        mass.empty() ? "mass that its maker took" : "consistent mass");
  if (!data.edges.empty())
    tell(
        "  note: made of quadratic elements: --U has the mesh's own vertices, without the {} edge "
        "points\n",
        data.edges.size());
  if (compact) tell("  note: a compact file; what is written are its rounded numbers\n");
}

Status write_light(const std::string& path, const BasisData& data, bool compact) {
  const Result<BasisData> light = without_interior(data);
  if (!light) return light.error();
  const BasisEncoding encoding = compact ? BasisEncoding::kCompact : BasisEncoding::kFull;
  if (Status status = write_basis(path, *light, encoding); !status) return status;
  show("{}: the body with the {} vertices of its boundary alone\n", path, light->vertex_count);
  if (light->load.vertices.empty() && !data.load.vertices.empty())
    tell("  note: its default load acts inside: it is left out\n");
  return Success{};
}

Status write_rescaled(const ExportOptions& options, BasisData data, bool compact) {
  const Result<BasisData> made = rescale_model(std::move(data), options.rescale, options.model);
  if (!made) return made.error();
  const BasisEncoding encoding = compact ? BasisEncoding::kCompact : BasisEncoding::kFull;
  if (Status status = write_basis(options.rescaled, *made, encoding); !status) return status;
  show("{}: the model with {}\n", options.rescaled, options.rescale);
  return Success{};
}

Status write_outputs(const ExportOptions& options, BasisReader& reader) {
  const Result<BasisData> data = read_basis(reader);
  if (!data) return data.error();
  if (!options.rescaled.empty())
    if (Status s = write_rescaled(options, *data, reader.compact()); !s) return s;
  const Result<VegaFiles> vega = read_vega_files(reader);
  if (!vega) return vega.error();
  const auto write = [](const std::string& path, const std::string& kept, const auto& make,
                        const char* what) -> Status {
    if (path.empty()) return Success{};
    Result<std::string> made = kept.empty() ? make() : Result<std::string>(kept);
    if (!made) return made.error();
    if (Status status = write_file(path, *made); !status) return status;
    show("{}: {}, {} bytes{}\n", path, what, made->size(),
         kept.empty() ? "" : ", as it was imported");
    return Success{};
  };
  Status status = write(
      options.cub, vega->cubic, [&] { return make_cub(*data); }, "forces");
  if (status)
    status = write(
        options.u, vega->basis, [&] { return make_u(*data); }, "basis");
  if (status && !options.vtu.empty()) {
    status =
        write_modes_vtu(options.vtu, data->surface.rest, std::span<const Triangle>(data->triangles),
                        data->surface.rows, data->lambda);
    if (status) show("{}: {} modes on the surface\n", options.vtu, data->lambda.size());
  }
  if (status && !options.light.empty())
    status = write_light(options.light, *data, reader.compact());
  const bool made =
      (!options.cub.empty() && vega->cubic.empty()) || (!options.u.empty() && vega->basis.empty());
  if (status && made) note_basis(*data, reader.compact());
  return status;
}

}  // namespace

int export_command(const ExportOptions& options) {
  if (Status status = check_outputs(options); !status) return report_error(status.error());
  const GuardedInputs guard({{options.model, "the basis file"}});
  Result<BasisReader> reader = BasisReader::open(options.model);
  if (!reader) return report_error(reader.error());
  if (Status status = write_outputs(options, *reader); !status) return report_error(status.error());
  return flushed(0);
}

}  // namespace tremolo
