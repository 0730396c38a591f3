// Reads everything in a basis file, for tools and tests. The runtime reads less.
#include "formats/basis/basis_reader.h"

namespace tremolo {
namespace {

using namespace basis_layout;

Status read_blocks(BasisReader& reader, BasisData& data) {
  if (Status s = take(data.surface, reader.vertex_block(kSurfaceIds, kSurfaceRest, kSurfaceBasis));
      !s)
    return s;
  if (!reader.has(kInteriorIds)) return Success{};
  return take(data.interior, reader.vertex_block(kInteriorIds, kInteriorRest, kInteriorBasis));
}

Status read_optional(BasisReader& reader, BasisData& data) {
  if (reader.has(kSingularValues))
    if (Status s = take(data.singular_values, reader.doubles(kSingularValues)); !s) return s;
  if (reader.has(kFixedIds))
    if (Status s = take(data.fixed_vertices, reader.indices(kFixedIds, data.vertex_count)); !s)
      return s;
  if (reader.has(kProvenance))
    if (Status s = take(data.provenance, reader.text(kProvenance)); !s) return s;
  if (!reader.has(kTotalMass)) return Success{};
  const Result<std::span<const double>> mass = reader.doubles(kTotalMass);
  if (!mass) return mass.error();
  data.total_mass = mass->front();
  return Success{};
}

}  // namespace

Result<std::vector<Triangle>> read_triangles(BasisReader& reader) {
  return reader.triangles(kTriangles, reader.dimensions().surface_vertices);
}

Result<Eigen::VectorXd> read_lambda(BasisReader& reader) {
  const Result<std::span<const double>> values = reader.doubles(kLambda);
  if (!values) return values.error();
  for (std::size_t i = 0; i < values->size(); ++i)
    if ((*values)[i] <= 0.0 || (i > 0 && (*values)[i] < (*values)[i - 1]))
      return content_error("section 'lambda': value " + std::to_string(i) +
                           " is not positive or does not ascend");
  return Eigen::VectorXd(Eigen::VectorXd::Map(values->data(), std::ssize(*values)));
}

Result<DefaultLoad> read_default_load(BasisReader& reader) {
  DefaultLoad load;
  if (!reader.has(kLoadIds)) return load;
  if (Status s = take(load.vertices, reader.indices(kLoadIds, reader.dimensions().vertices)); !s)
    return s.error();
  if (Status s = take(load.forces, reader.points(kLoadForces)); !s) return s.error();
  return load;
}

Result<std::vector<MeshEdge>> read_edges(BasisReader& reader) {
  std::vector<MeshEdge> edges;
  if (!reader.has(kEdgePoints)) return edges;
  const auto ids = reader.indices(kEdgePoints, reader.dimensions().vertices);
  if (!ids) return ids.error();
  for (std::size_t i = 0; i < ids->size(); i += 3) {
    const auto id = [&](std::size_t k) { return static_cast<VertexId>((*ids)[i + k]); };
    const MeshEdge edge{id(0), id(1), id(2)};
    if (edge.a >= edge.b || (!edges.empty() && edges.back().point >= edge.point))
      return content_error("section 'edge_points': edge " + std::to_string(i / 3) +
                           " has its ends or its place in the list out of order");
    edges.push_back(edge);
  }
  return edges;
}

Result<std::optional<InertiaIntegrals>> read_inertia(BasisReader& reader) {
  if (!reader.has(kInertiaRest)) return std::optional<InertiaIntegrals>();
  const auto rest = reader.doubles(kInertiaRest);
  if (!rest) return rest.error();
  const auto linear = reader.doubles(kInertiaLinear);
  if (!linear) return linear.error();
  const auto pairs = reader.doubles(kInertiaPairs);
  if (!pairs) return pairs.error();
  InertiaIntegrals inertia;
  inertia.mass = rest->front();
  if (!(inertia.mass > 0)) return content_error("section 'inertia_rest': the mass is not positive");
  inertia.first_moment = Eigen::Map<const Eigen::Vector3d>(rest->data() + 1);
  inertia.second_moment = Eigen::Map<const Eigen::Matrix3d>(rest->data() + 4);
  inertia.linear = Eigen::Map<const Eigen::MatrixXd>(linear->data(), 12, std::ssize(*linear) / 12);
  inertia.B = Eigen::Map<const Eigen::MatrixXd>(pairs->data(), 9, std::ssize(*pairs) / 9);
  return std::optional(std::move(inertia));
}

Result<MassElements> read_elements(BasisReader& reader) {
  MassElements elements;
  if (!reader.has(kTetrahedra)) return elements;
  const auto ids = reader.indices(kTetrahedra, reader.dimensions().vertices);
  if (!ids) return ids.error();
  const auto masses = reader.doubles(kTetrahedronMasses);
  if (!masses) return masses.error();
  for (std::size_t e = 0; e < masses->size(); ++e) {
    if (!((*masses)[e] > 0.0))
      return content_error("section 'tetra_masses': mass " + std::to_string(e) +
                           " is not positive");
    Tetrahedron& corners = elements.corners.emplace_back();
    for (std::size_t a = 0; a < 4; ++a) corners[a] = static_cast<VertexId>((*ids)[4 * e + a]);
  }
  elements.masses.assign(masses->begin(), masses->end());
  return elements;
}

Result<VegaFiles> read_vega_files(BasisReader& reader) {
  VegaFiles files;
  for (const auto& [name, bytes] :
       {std::pair{kVegaBasis, &files.basis}, {kVegaCubic, &files.cubic}})
    if (reader.has(name))
      if (Status s = take(*bytes, reader.text(name)); !s) return s.error();
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
  if (Status s = take(data.lambda, read_lambda(reader)); !s) return s.error();
  if (Status s = take(data.cubic, reader.coefficients(kCubic)); !s) return s.error();
  if (Status s = take(data.quartic, reader.coefficients(kQuartic)); !s) return s.error();
  if (Status s = take(data.strain_gram, reader.strain_gram()); !s) return s.error();
  if (Status s = read_blocks(reader, data); !s) return s.error();
  if (Status s = take(data.triangles, read_triangles(reader)); !s) return s.error();
  if (Status s = take(data.load, read_default_load(reader)); !s) return s.error();
  if (Status s = take(data.edges, read_edges(reader)); !s) return s.error();
  if (Status s = take(data.render, read_render(reader)); !s) return s.error();
  if (Status s = take(data.inertia, read_inertia(reader)); !s) return s.error();
  if (Status s = take(data.elements, read_elements(reader)); !s) return s.error();
  if (Status s = take(data.response, read_response(reader)); !s) return s.error();
  if (!data.response.at.empty())
    if (Status s = take(data.response.interior, read_response_inside(reader)); !s) return s.error();
  if (Status s = read_optional(reader, data); !s) return s.error();
  return data;
}

Result<BasisData> read_basis(const std::string& path) {
  Result<BasisReader> reader = BasisReader::open(path);
  if (!reader) return reader.error();
  return read_basis(*reader);
}

}  // namespace tremolo
