#include "precompute/fem/stvk.h"

namespace tremolo {
namespace {

Eigen::Matrix3d symmetric_part(const Eigen::Matrix3d& a) {
  return 0.5 * (a + a.transpose());
}

// Adds an element's forces to the rows of its nodes; a negative row is skipped.
void add_to_rows(const Solid& solid, std::size_t element, const PiolaField& piola,
                 const std::vector<int>& row_of_vertex, double* out) {
  const NodeForces forces = piola.forces(solid.elements[element]);
  const ElementNodes nodes = element_nodes(solid.mesh, element);
  for (int i = 0; i < nodes.count; ++i) {
    const int row = row_of_vertex[nodes[i]];
    if (row >= 0) Eigen::Map<Eigen::Vector3d>(out + row) += forces.col(i);
  }
}

}  // namespace

std::vector<ElementGeometry> element_geometry(const TetMesh& mesh) {
  std::vector<ElementGeometry> elements;
  elements.reserve(mesh.tetrahedra.size());
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    std::array<Eigen::Vector3d, 4> corners;
    for (std::size_t a = 0; a < 4; ++a) corners[a] = mesh.vertices[tet[a]];
    elements.push_back(element_geometry(corners));
  }
  return elements;
}

Solid make_solid(const TetMesh& mesh, const Material& material) {
  return make_solid(mesh, MaterialTable{{{"", material}}, {}});
}

Solid make_solid(const TetMesh& mesh, const MaterialTable& table) {
  Solid solid{mesh, element_geometry(mesh), {}, {}, table.of_tet, {}};
  for (const NamedMaterial& named : table.materials) {
    solid.elasticities.push_back(make_elasticity(named.material));
    solid.densities.push_back(named.material.density);
  }
  return solid;
}

Solid make_solid(const TetMesh& part, const std::vector<std::size_t>& tetrahedra,
                 const MaterialTable& table) {
  MaterialTable chosen{table.materials, {}};
  if (!table.of_tet.empty())
    for (const std::size_t e : tetrahedra) chosen.of_tet.push_back(table.of_tet[e]);
  return make_solid(part, chosen);
}

GradientField displacement_gradients(const Solid& solid, std::size_t element, const FieldRef& u) {
  const ElementNodes nodes = element_nodes(solid.mesh, element);
  return gradient_field(solid.elements[element], solid.order(),
                        [&](int node) { return u.segment<3>(3 * Eigen::Index{nodes[node]}); });
}

Eigen::Matrix3d green_strain(const Eigen::Matrix3d& g) {
  return symmetric_part(g) + 0.5 * g.transpose() * g;
}

double strain_energy(const Solid& solid, const FieldRef& u) {
  double energy = 0;
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const GradientField gradients = displacement_gradients(solid, e, u);
    for (const SamplePoint& point : sample_points(solid.order(), 4)) {
      const Eigen::Matrix3d strain = green_strain(gradients(point));
      energy += 0.5 * (point.share * solid.elements[e].volume) *
                stress(solid.elasticity(e), strain).cwiseProduct(strain).sum();
    }
  }
  return energy;
}

Field internal_force(const Solid& solid, const FieldRef& u) {
  return internal_force(solid, u, solid.elements.size());
}

Field internal_force(const Solid& solid, const FieldRef& u, std::size_t count) {
  Field force = Field::Zero(u.size());
  for (std::size_t e = 0; e < count; ++e) {
    const ElementGeometry& element = solid.elements[e];
    const GradientField gradients = displacement_gradients(solid, e, u);
    PiolaField piola(solid.order());
    for (const SamplePoint& point : sample_points(solid.order(), 4)) {
      const Eigen::Matrix3d g = gradients(point);
      piola.add(point, (point.share * element.volume) * (Eigen::Matrix3d::Identity() + g) *
                           stress(solid.elasticity(e), green_strain(g)));
    }
    const NodeForces forces = piola.forces(element);
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int i = 0; i < nodes.count; ++i)
      force.segment<3>(3 * Eigen::Index{nodes[i]}) += forces.col(i);
  }
  return force;
}

void add_second_derivative(const Solid& solid, const std::vector<int>& elements, const FieldRef& a,
                           const FieldRef& b, const std::vector<int>& row_of_vertex, double* out) {
  for (int element : elements) {
    const std::size_t e = element;
    const Elasticity& elasticity = solid.elasticity(e);
    const GradientField field_a = displacement_gradients(solid, e, a);
    const GradientField field_b = displacement_gradients(solid, e, b);
    PiolaField piola(solid.order());
    for (const SamplePoint& point : sample_points(solid.order(), 3)) {
      const Eigen::Matrix3d ga = field_a(point), gb = field_b(point);
      piola.add(point, (point.share * solid.elements[e].volume) *
                           (stress(elasticity, symmetric_part(ga.transpose() * gb)) +
                            ga * stress(elasticity, symmetric_part(gb)) +
                            gb * stress(elasticity, symmetric_part(ga))));
    }
    add_to_rows(solid, e, piola, row_of_vertex, out);
  }
}

void add_third_derivative(const Solid& solid, const std::vector<int>& elements,
                          const std::array<Field, 3>& fields, const std::vector<int>& row_of_vertex,
                          double* out) {
  for (int element : elements) {
    const std::size_t e = element;
    const Elasticity& elasticity = solid.elasticity(e);
    std::array<GradientField, 3> gradients;
    for (std::size_t i = 0; i < 3; ++i) gradients[i] = displacement_gradients(solid, e, fields[i]);
    PiolaField piola(solid.order());
    for (const SamplePoint& point : sample_points(solid.order(), 4)) {
      const Eigen::Matrix3d a = gradients[0](point), b = gradients[1](point),
                            c = gradients[2](point);
      piola.add(point, (point.share * solid.elements[e].volume) *
                           (a * stress(elasticity, symmetric_part(b.transpose() * c)) +
                            b * stress(elasticity, symmetric_part(c.transpose() * a)) +
                            c * stress(elasticity, symmetric_part(a.transpose() * b))));
    }
    add_to_rows(solid, e, piola, row_of_vertex, out);
  }
}

ElementStiffness rest_stiffness(const Solid& solid, std::size_t element) {
  return rest_stiffness(solid.elements[element], solid.elasticity(element), solid.order());
}

}  // namespace tremolo
