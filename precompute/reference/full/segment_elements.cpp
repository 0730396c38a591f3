#include <numbers>

#include "precompute/reference/full/full_order.h"

namespace tremolo {
namespace {

struct Deformation {
  Eigen::Matrix3d gradient;  // F = I + G
  Eigen::Matrix3d stress;    // S
};

Deformation deform(const Solid& solid, std::size_t element, const Eigen::Matrix3d& g) {
  return {Eigen::Matrix3d::Identity() + g, stress(solid.elasticity(element), green_strain(g))};
}

// The change of the strain over the segment.
Eigen::Matrix3d strain_change(const Eigen::Matrix3d& from, const Eigen::Matrix3d& by) {
  return green_strain(from + by) - green_strain(from);
}

// At a point of the segment, with the stress of `point`.
Deformation deform(const Solid& solid, std::size_t element, const SegmentPoint& point,
                   const Eigen::Matrix3d& from, const Eigen::Matrix3d& by) {
  Deformation at = deform(solid, element, from + point.fraction * by);
  if (point.rate) at.stress = stress(solid.elasticity(element), strain_change(from, by));
  return at;
}

// Returns the derivative of the strain, in Mandel's notation, with respect to one node: 6 x 3.
Eigen::Matrix<double, 6, 3> strain_derivative(const Eigen::Matrix3d& f, const Eigen::Vector3d& g) {
  constexpr double h = std::numbers::sqrt2 / 2.0;
  Eigen::Matrix<double, 6, 3> b;
  for (int x = 0; x < 3; ++x) {
    const Eigen::Vector3d r = f.row(x);
    b.col(x) << r.x() * g.x(), r.y() * g.y(), r.z() * g.z(), h * (r.y() * g.z() + r.z() * g.y()),
        h * (r.x() * g.z() + r.z() * g.x()), h * (r.x() * g.y() + r.y() * g.x());
  }
  return b;
}

void add_isotropic(const Elasticity& law, const Deformation& at, const NodeGradients& g,
                   double weight, std::span<Eigen::Matrix3d> blocks) {
  const NodeGradients moved = at.gradient * g;
  const NodeGradients pulled = at.stress * g;
  const Eigen::Matrix3d left = (weight * law.mu) * at.gradient * at.gradient.transpose();
  for (int b = 0; b < g.cols(); ++b)
    for (int a = 0; a <= b; ++a) {
      Eigen::Matrix3d& block = blocks[element_block(a, b)];
      block += g.col(a).dot(g.col(b)) * left;
      block += ((weight * law.lambda) * moved.col(a)) * moved.col(b).transpose();
      block += ((weight * law.mu) * moved.col(b)) * moved.col(a).transpose();
      block.diagonal().array() += weight * g.col(a).dot(pulled.col(b));
    }
}

void add_general(const Elasticity& law, const Deformation& at, const NodeGradients& g,
                 double weight, std::span<Eigen::Matrix3d> blocks) {
  const NodeGradients pulled = at.stress * g;
  std::array<Eigen::Matrix<double, 6, 3>, kMostNodes> change, stressed;
  for (int a = 0; a < g.cols(); ++a) {
    change[a] = strain_derivative(at.gradient, g.col(a));
    stressed[a] = weight * law.tensor * change[a];
  }
  for (int b = 0; b < g.cols(); ++b)
    for (int a = 0; a <= b; ++a) {
      Eigen::Matrix3d& block = blocks[element_block(a, b)];
      block += change[a].transpose() * stressed[b];
      block.diagonal().array() += weight * g.col(a).dot(pulled.col(b));
    }
}

}  // namespace

double element_energy(const Solid& solid, std::size_t element, const Field& u) {
  const GradientField gradients = displacement_gradients(solid, element, u);
  double energy = 0;
  for (const SamplePoint& sample : sample_points(solid.order(), 4)) {
    const Eigen::Matrix3d strain = green_strain(gradients(sample));
    energy += 0.5 * (sample.share * solid.elements[element].volume) *
              stress(solid.elasticity(element), strain).cwiseProduct(strain).sum();
  }
  return energy;
}

double element_strain_change_work(const Solid& solid, std::size_t element, const Field& u,
                                  const Field& d) {
  const GradientField start = displacement_gradients(solid, element, u);
  const GradientField change = displacement_gradients(solid, element, d);
  double work = 0;
  for (const SamplePoint& sample : sample_points(solid.order(), 4)) {
    const Eigen::Matrix3d strain = strain_change(start(sample), change(sample));
    work += (sample.share * solid.elements[element].volume) *
            stress(solid.elasticity(element), strain).cwiseProduct(strain).sum();
  }
  return work;
}

NodeForces element_force(const Solid& solid, std::size_t element,
                         const std::vector<SegmentPoint>& points, const Field& u, const Field& d) {
  const GradientField start = displacement_gradients(solid, element, u);
  const GradientField change = displacement_gradients(solid, element, d);
  const double volume = solid.elements[element].volume;
  PiolaField piola(solid.order());
  for (const SamplePoint& sample : sample_points(solid.order(), 4)) {
    const Eigen::Matrix3d from = start(sample), by = change(sample);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const SegmentPoint& point : points) {
      const Deformation at = deform(solid, element, point, from, by);
      sum += (point.weight * (sample.share * volume)) * at.gradient * at.stress;
    }
    piola.add(sample, sum);
  }
  return piola.forces(solid.elements[element]);
}

void element_tangent(const Solid& solid, std::size_t element,
                     const std::vector<SegmentPoint>& points, const Field& u, const Field& d,
                     std::span<Eigen::Matrix3d> blocks) {
  const GradientField start = displacement_gradients(solid, element, u);
  const GradientField change = displacement_gradients(solid, element, d);
  const ElementGeometry& geometry = solid.elements[element];
  const Elasticity& law = solid.elasticity(element);
  for (Eigen::Matrix3d& block : blocks) block.setZero();
  for (const SamplePoint& sample : sample_points(solid.order(), 4)) {
    const Eigen::Matrix3d from = start(sample), by = change(sample);
    const NodeGradients gradients = node_gradients(geometry, solid.order(), sample);
    for (const SegmentPoint& point : points) {
      Deformation at = deform(solid, element, point, from, by);
      // The stress of the strain's change has all of the strain's derivative.
      if (point.rate) at.stress *= point.fraction;
      const double weight =
          point.weight * (point.rate ? 1.0 : point.fraction) * (sample.share * geometry.volume);
      if (law.isotropic)
        add_isotropic(law, at, gradients, weight, blocks);
      else
        add_general(law, at, gradients, weight, blocks);
    }
  }
}

}  // namespace tremolo
