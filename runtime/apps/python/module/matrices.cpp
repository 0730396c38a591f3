// Mass and stiffness of a whole mesh at rest, for scipy.sparse.
#include <utility>

#include "common/elements/element.h"
#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
#include "runtime/apps/python/module/convert.h"

namespace tremolo::python {
namespace {

// Entries of a sparse matrix over control values: row, column, value.
struct Entries {
  std::vector<std::int32_t> rows, columns;
  std::vector<double> values;

  void add(Eigen::Index row, Eigen::Index column, double value) {
    rows.push_back(static_cast<std::int32_t>(row));
    columns.push_back(static_cast<std::int32_t>(column));
    values.push_back(value);
  }
  py::tuple as_tuple() const {
    const auto n = static_cast<py::ssize_t>(values.size());
    return py::make_tuple(py::array_t<double>(n, values.data()),
                          py::array_t<std::int32_t>(n, rows.data()),
                          py::array_t<std::int32_t>(n, columns.data()));
  }
};

void add_element(const TetMesh& mesh, std::size_t t, int order, const Elasticity& elasticity,
                 double density, bool lumped, Entries& mass, Entries& stiffness) {
  std::array<Eigen::Vector3d, 4> corners;
  std::array<VertexId, kMostNodes> nodes{};
  for (std::size_t i = 0; i < 4; ++i) {
    nodes[i] = mesh.tetrahedra[t][i];
    corners[i] = mesh.vertices[static_cast<std::size_t>(nodes[i])];
  }
  if (order == 2)
    for (std::size_t e = 0; e < 6; ++e) nodes[4 + e] = mesh.edge_points[t][e];
  const ElementGeometry geometry = element_geometry(corners);
  const ElementStiffness block = rest_stiffness(geometry, elasticity, order);
  const int count = nodes_of_order(order);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const double share = lumped ? (i == j ? weight_share(order) : 0.0) : mass_share(order, i, j);
      for (int a = 0; a < 3; ++a) {
        const Eigen::Index row = 3 * Eigen::Index{nodes[i]} + a;
        if (share != 0.0)
          mass.add(row, 3 * Eigen::Index{nodes[j]} + a, density * geometry.volume * share);
        for (int b = 0; b < 3; ++b)
          stiffness.add(row, 3 * Eigen::Index{nodes[j]} + b, block(3 * i + a, 3 * j + b));
      }
    }
}

// (mass, stiffness, edges, vertices): the first two as (values, rows, columns) over control values.
py::tuple entries(py::handle vertices, py::handle tets, double young, double poisson,
                  double density, int order, bool lumped) {
  TetMesh mesh;
  mesh.vertices = points(vertices, "vertices");
  mesh.tetrahedra = tetrahedra(tets, "tetrahedra");
  if (order != 1 && order != 2) raise(usage_error("order: expected 1 or 2"));
  Material material;
  material.young = young;
  material.poisson = poisson;
  material.density = density;
  check(check_material(material));
  unwrap(check_mesh(mesh));
  if (order == 2) check(add_edge_points(mesh));
  const Elasticity elasticity = make_elasticity(material);
  Entries mass, stiffness;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    add_element(mesh, t, order, elasticity, density, lumped, mass, stiffness);
  py::array_t<VertexId> edges(Shape{static_cast<py::ssize_t>(mesh.edges.size()), 3});
  VertexId* out = edges.mutable_data();
  for (const MeshEdge& edge : mesh.edges)
    for (const VertexId id : {edge.point, edge.a, edge.b}) *out++ = id;
  return py::make_tuple(mass.as_tuple(), stiffness.as_tuple(), edges, mesh.vertices.size());
}

}  // namespace

void add_matrices(py::module_& module) {
  module.def("matrix_entries", &entries, py::arg("vertices"), py::arg("tetrahedra"),
             py::arg("young"), py::arg("poisson"), py::arg("density"), py::arg("order"),
             py::arg("lumped"),
             "Entries of M and K over the control values of the elements; tremolo.matrices makes "
             "scipy's matrices of them.");
}

}  // namespace tremolo::python
