#include "precompute/reference/world/world_body.h"

namespace tremolo {
namespace {

template <class ValueAt>
Field of_held(const WorldBody& world, const ValueAt& value_at) {
  const std::vector<int>& of_dof = world.body.unknowns.of_dof;
  Field field = Field::Zero(of_dof.size());
  for (std::size_t v = 0; 3 * v < of_dof.size(); ++v)
    if (of_dof[3 * v] < 0)
      field.segment<3>(3 * static_cast<Eigen::Index>(v)) =
          value_at(world.body.solid.mesh.vertices[v]);
  return field;
}

}  // namespace

Field held_displacement(const WorldBody& world, const RigidMotion& support) {
  return of_held(world, [&](const Eigen::Vector3d& rest) -> Eigen::Vector3d {
    return support.place(rest) - rest;
  });
}

Field held_velocity(const WorldBody& world, const RigidMotion& support) {
  return of_held(world, [&](const Eigen::Vector3d& rest) -> Eigen::Vector3d {
    return support.velocity_at(support.place(rest));
  });
}

Vector riding_velocity(const WorldBody& world, const RigidMotion& support, const Vector& u) {
  const Unknowns& unknowns = world.body.unknowns;
  Vector velocity(u.size());
  for (Eigen::Index i = 0; i < u.size(); i += 3) {
    const std::size_t vertex = unknowns.dof[i] / 3;
    velocity.segment<3>(i) =
        support.velocity_at(world.body.solid.mesh.vertices[vertex] + u.segment<3>(i));
  }
  return velocity;
}

Field whole_mass_times(const WorldBody& world, const Field& x) {
  const Solid& solid = world.body.solid;
  Field product = Field::Zero(x.size());
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int a = 0; a < nodes.count; ++a)
      for (int b = 0; b < nodes.count; ++b)
        product.segment<3>(3 * Eigen::Index{nodes[a]}) +=
            element_mass(solid, e, a, b, world.mass) * x.segment<3>(3 * Eigen::Index{nodes[b]});
  }
  for (std::size_t v = 0; v < solid.point_mass.size(); ++v) {
    const auto at = 3 * static_cast<Eigen::Index>(v);
    product.segment<3>(at) += solid.point_mass[v] * x.segment<3>(at);
  }
  return product;
}

}  // namespace tremolo
