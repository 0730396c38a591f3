#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "formats/basis/basis_reader.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/load.h"

namespace tremolo {
namespace {

// The solid within the boundary, as if its mass were spread evenly: volume (m^3), centre (m),
// and the integral of x x^T about the centre over the volume (m^2).
struct Shape {
  double volume = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
};

// Sums over the tetrahedra between the origin and each triangle of the closed boundary.
Shape shape_of(const Model& model) {
  Shape shape;
  for (const Triangle& t : model.triangles()) {
    const auto corner = [&](int k) { return model.surface().rest[t[k]]; };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2), sum = a + b + c;
    const double volume = a.dot(b.cross(c)) / 6.0;
    shape.volume += volume;
    shape.centre += volume * sum / 4.0;
    shape.spread +=
        volume / 20.0 *
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  shape.centre /= shape.volume;
  shape.spread = shape.spread / shape.volume - shape.centre * shape.centre.transpose();
  return shape;
}

}  // namespace

RigidLoss rigid_loss(const Model& model, const DefaultLoad& load, double mass,
                     std::uint64_t rigid_modes) {
  RigidLoss loss;
  loss.rigid_modes = rigid_modes;
  const Shape shape = shape_of(model);
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = force;
  for (std::size_t i = 0; i < load.vertices.size(); ++i) {
    const Result<VertexRows> vertex = model.vertex(load.vertices[i]);
    if (!vertex) continue;
    force += load.forces[i];
    torque += (vertex->rest - shape.centre).cross(load.forces[i]);
  }
  loss.force = force.norm();
  loss.torque = torque.norm();
  loss.share = std::numeric_limits<double>::quiet_NaN();
  const Result<Eigen::VectorXd> reduced = reduce_load(model, load);
  if (rigid_modes != 6 || !(mass > 0) || !reduced) return loss;
  const Eigen::Matrix3d inertia =
      mass * (shape.spread.trace() * Eigen::Matrix3d::Identity() - shape.spread);
  const double whole = force.squaredNorm() / mass + torque.dot(inertia.ldlt().solve(torque));
  loss.share = whole / (whole + reduced->squaredNorm());
  return loss;
}

Result<std::optional<RigidLoss>> rigid_loss(const RunInput& input) {
  using Loss = std::optional<RigidLoss>;
  Result<BasisReader> reader = BasisReader::open(input.scene.body().model);
  if (!reader) return reader.error();
  const std::uint64_t rigid = reader->dimensions().rigid;
  if (rigid == 0 || input.forces.vertices.empty()) return Loss();
  double mass = 0.0;
  if (reader->has(basis_layout::kTotalMass)) {
    const Result<std::span<const double>> stored = reader->doubles(basis_layout::kTotalMass);
    if (!stored) return stored.error();
    mass = stored->front();
  }
  return Loss(rigid_loss(*input.model, input.forces, mass, rigid));
}

}  // namespace tremolo
