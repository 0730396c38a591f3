// Everything in a basis file as values: what tools and tests want. The runtime reads less.
#include "formats/basis/basis_reader.h"

namespace tremolo {
namespace {

using namespace basis_layout;

template <class Target, class Source>
Status take(Target& target, const Result<Source>& source) {
  if (!source) return source.error();
  target.assign(source->begin(), source->end());
  return Success{};
}

Status read_optional(BasisReader& reader, BasisData& data) {
  if (reader.has(kSingularValues))
    if (Status s = take(data.singular_values, reader.doubles(kSingularValues)); !s) return s;
  if (reader.has(kFixedIds))
    if (Status s = take(data.fixed_vertices, reader.indices(kFixedIds, data.vertex_count)); !s)
      return s;
  if (reader.has(kProvenance))
    if (Status s = take(data.provenance, reader.text(kProvenance)); !s) return s;
  if (reader.has(kTotalMass)) {
    Result<std::span<const double>> mass = reader.doubles(kTotalMass);
    if (!mass) return mass.error();
    data.total_mass = mass->front();
  }
  return Success{};
}

Status read_blocks(BasisReader& reader, BasisData& data) {
  Result<VertexBlock> surface = reader.vertex_block(kSurfaceIds, kSurfaceRest, kSurfaceBasis);
  if (!surface) return surface.error();
  data.surface = std::move(*surface);
  if (!reader.has(kInteriorIds)) return Success{};
  Result<VertexBlock> interior = reader.vertex_block(kInteriorIds, kInteriorRest, kInteriorBasis);
  if (!interior) return interior.error();
  data.interior = std::move(*interior);
  return Success{};
}

}  // namespace

Result<std::vector<Triangle>> read_triangles(BasisReader& reader) {
  const Result<std::span<const std::uint32_t>> ids =
      reader.indices(kTriangles, reader.dimensions().surface_vertices);
  if (!ids) return ids.error();
  std::vector<Triangle> triangles(ids->size() / 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t corner = 0; corner < 3; ++corner)
      triangles[t][corner] = static_cast<VertexId>((*ids)[3 * t + corner]);
  return triangles;
}

Result<Eigen::VectorXd> read_lambda(BasisReader& reader) {
  const Result<std::span<const double>> values = reader.doubles(kLambda);
  if (!values) return values.error();
  for (std::size_t i = 0; i < values->size(); ++i)
    if ((*values)[i] <= 0.0 || (i > 0 && (*values)[i] < (*values)[i - 1]))
      return content_error("section 'lambda': value " + std::to_string(i) +
                           " is not positive or does not ascend");
  return Eigen::VectorXd(
      Eigen::Map<const Eigen::VectorXd>(values->data(), static_cast<Eigen::Index>(values->size())));
}

Result<DefaultLoad> read_default_load(BasisReader& reader) {
  DefaultLoad load;
  if (!reader.has(kLoadIds)) return load;
  if (Status s = take(load.vertices, reader.indices(kLoadIds, reader.dimensions().vertices)); !s)
    return s.error();
  const Result<std::span<const double>> forces = reader.doubles(kLoadForces);
  if (!forces) return forces.error();
  load.forces.resize(load.vertices.size());
  for (std::size_t i = 0; i < load.forces.size(); ++i)
    load.forces[i] = Eigen::Map<const Eigen::Vector3d>(forces->data() + 3 * i);
  return load;
}

Result<VegaFiles> read_vega_files(BasisReader& reader) {
  VegaFiles files;
  if (reader.has(kVegaBasis))
    if (Status s = take(files.basis, reader.text(kVegaBasis)); !s) return s.error();
  if (reader.has(kVegaCubic))
    if (Status s = take(files.cubic, reader.text(kVegaCubic)); !s) return s.error();
  return files;
}

Result<BasisData> read_basis(BasisReader& reader) {
  const BasisDimensions& d = reader.dimensions();
  BasisData data;
  data.vertex_count = d.vertices;
  data.tetrahedron_count = d.tetrahedra;
  data.linear_mode_count = d.linear_modes;
  data.fixed_vertex_count = d.fixed;
  data.rigid_mode_count = d.rigid;
  Result<Eigen::VectorXd> lambda = read_lambda(reader);
  if (!lambda) return lambda.error();
  data.lambda = std::move(*lambda);
  if (Status s = take(data.cubic, reader.coefficients(kCubic)); !s) return s.error();
  if (Status s = take(data.quartic, reader.coefficients(kQuartic)); !s) return s.error();
  if (Status s = read_blocks(reader, data); !s) return s.error();
  Result<std::vector<Triangle>> triangles = read_triangles(reader);
  if (!triangles) return triangles.error();
  data.triangles = std::move(*triangles);
  Result<DefaultLoad> load = read_default_load(reader);
  if (!load) return load.error();
  data.load = std::move(*load);
  Result<std::optional<RenderBlock>> render = read_render(reader);
  if (!render) return render.error();
  data.render = std::move(*render);
  if (Status s = read_optional(reader, data); !s) return s.error();
  return data;
}

Result<BasisData> read_basis(const std::string& path) {
  Result<BasisReader> reader = BasisReader::open(path);
  if (!reader) return reader.error();
  return read_basis(*reader);
}

}  // namespace tremolo
