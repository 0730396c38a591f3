#include "common/elements/element.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace tremolo {
namespace {

constexpr SamplePoint kCentre{};

// The point whose coordinate a is `high`, the others `low`.
SamplePoint towards_corner(double share, double high, double low, std::size_t a) {
  SamplePoint point{share, {low, low, low, low}};
  point.lambda[a] = high;
  return point;
}

// Exact for degree 2.
std::array<SamplePoint, 4> four_points() {
  const double root = std::sqrt(5.0);
  std::array<SamplePoint, 4> points;
  for (std::size_t a = 0; a < 4; ++a)
    points[a] = towards_corner(0.25, (5.0 + 3.0 * root) / 20.0, (5.0 - root) / 20.0, a);
  return points;
}

// Exact for degree 3. In terms of gradients: 120 integral l_a l_b l_c = 6 V n_abc with
// n = sum over the points of their weights times v v v.
std::array<SamplePoint, 5> five_points() {
  std::array<SamplePoint, 5> points;
  for (std::size_t a = 0; a < 4; ++a) points[a] = towards_corner(0.45, 0.5, 1.0 / 6.0, a);
  points[4] = kCentre;
  points[4].share = -0.8;
  return points;
}

// Exact for degree 4 (Keast 1986).
std::array<SamplePoint, 11> eleven_points() {
  std::array<SamplePoint, 11> points;
  for (std::size_t a = 0; a < 4; ++a)
    points[a] = towards_corner(343.0 / 7500.0, 11.0 / 14.0, 1.0 / 14.0, a);
  const double root = std::sqrt(5.0 / 14.0);
  for (std::size_t e = 0; e < 6; ++e) {
    SamplePoint& point = points[4 + e];
    point.share = 56.0 / 375.0;
    point.lambda.fill((1.0 - root) / 4.0);
    for (const int a : kTetEdges[e]) point.lambda[a] = (1.0 + root) / 4.0;
  }
  points[10] = kCentre;
  points[10].share = -148.0 / 1875.0;
  return points;
}

}  // namespace

std::span<const SamplePoint> sample_points(int order, int gradients) {
  static const std::array<SamplePoint, 4> four = four_points();
  static const std::array<SamplePoint, 5> five = five_points();
  static const std::array<SamplePoint, 11> eleven = eleven_points();
  if (order == 1) return {&kCentre, 1};
  if (gradients <= 2) return four;
  if (gradients == 3) return five;
  return eleven;
}

NodeGradients node_gradients(const ElementGeometry& element, int order, const SamplePoint& point) {
  if (order == 1) return element.gradients;
  const auto& grad = element.gradients;
  const std::array<double, 4>& l = point.lambda;
  NodeGradients gradients(3, kMostNodes);
  for (int a = 0; a < 4; ++a) {
    gradients.col(a) = 2.0 * l[a] * grad.col(a);
    for (int b = a + 1; b < 4; ++b)
      gradients.col(kNodeAt[a][b]) = 2.0 * (l[a] * grad.col(b) + l[b] * grad.col(a));
  }
  return gradients;
}

double mass_share(int order, int i, int j) {
  if (order == 1) return i == j ? 0.1 : 0.05;
  // Exponents of a polynomial: the integral is prod_s C(I_s + J_s, I_s) / 210.
  const auto exponents = [](int node) {
    std::array<int, 4> e{};
    if (node < 4) {
      e[node] = 2;
    } else {
      for (const int a : kTetEdges[node - 4]) e[a] = 1;
    }
    return e;
  };
  constexpr double kChoose[3][3] = {{1, 1, 1}, {1, 2, 3}, {1, 3, 6}};  // C(p + q, p)
  const std::array<int, 4> p = exponents(i), q = exponents(j);
  double product = 1.0 / 210.0;
  for (std::size_t s = 0; s < 4; ++s) product *= kChoose[p[s]][q[s]];
  return product;
}

std::array<double, kMostNodes> polynomials_at(int order, const std::array<double, 4>& lambda) {
  std::array<double, kMostNodes> values{};
  if (order == 1) {
    std::copy(lambda.begin(), lambda.end(), values.begin());
    return values;
  }
  std::array<double, 4> inside, beyond;
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += inside[a] = std::max(0.0, lambda[a]);
  const bool outside = *std::min_element(lambda.begin(), lambda.end()) < 0;
  for (std::size_t a = 0; a < 4; ++a) {
    if (outside) inside[a] /= sum;
    beyond[a] = outside ? lambda[a] - inside[a] : 0.0;
  }
  for (std::size_t a = 0; a < 4; ++a) {
    values[a] = inside[a] * (inside[a] + 2.0 * beyond[a]);
    for (std::size_t b = a + 1; b < 4; ++b)
      values[kNodeAt[a][b]] =
          2.0 * (inside[a] * inside[b] + inside[a] * beyond[b] + beyond[a] * inside[b]);
  }
  return values;
}

Eigen::Matrix3d GradientField::operator()(const SamplePoint& point) const {
  if (count == 1) return at[0];
  return point.lambda[0] * at[0] + point.lambda[1] * at[1] + point.lambda[2] * at[2] +
         point.lambda[3] * at[3];
}

PiolaField::PiolaField(int order) : count(order == 1 ? 1 : 4) {
  at.fill(Eigen::Matrix3d::Zero());
}

void PiolaField::add(const SamplePoint& point, const Eigen::Matrix3d& weighted) {
  if (count == 1) {
    at[0] += weighted;
    return;
  }
  for (std::size_t a = 0; a < 4; ++a) at[a] += point.lambda[a] * weighted;
}

NodeForces PiolaField::forces(const ElementGeometry& element) const {
  if (count == 1) return at[0] * element.gradients;
  NodeForces forces(3, kMostNodes);
  for (int a = 0; a < 4; ++a) {
    forces.col(a) = 2.0 * at[a] * element.gradients.col(a);
    for (int b = a + 1; b < 4; ++b)
      forces.col(kNodeAt[a][b]) =
          2.0 * (at[a] * element.gradients.col(b) + at[b] * element.gradients.col(a));
  }
  return forces;
}

namespace {

// Adds weight B^T C B, where B maps the nodes' displacements to the strain in Mandel's notation.
void add_general(const Elasticity& elasticity, const NodeGradients& gradients, double weight,
                 ElementStiffness& stiffness) {
  Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 3 * kMostNodes> b(
      6, 3 * gradients.cols());
  for (int a = 0; a < gradients.cols(); ++a) {
    const Eigen::Vector3d g = gradients.col(a);
    const double h = std::numbers::sqrt2 / 2.0;
    b.middleCols<3>(3 * a) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), 0, h * g.z(), h * g.y(),
        h * g.z(), 0, h * g.x(), h * g.y(), h * g.x(), 0;
  }
  stiffness += weight * b.transpose() * elasticity.tensor * b;
}

void add_isotropic(const Elasticity& elasticity, const NodeGradients& gradients, double weight,
                   ElementStiffness& stiffness) {
  const double lambda = elasticity.lambda;
  const double mu = elasticity.mu;
  for (int a = 0; a < gradients.cols(); ++a)
    for (int b = 0; b < gradients.cols(); ++b) {
      const Eigen::Vector3d ga = gradients.col(a);
      const Eigen::Vector3d gb = gradients.col(b);
      Eigen::Matrix3d block = lambda * ga * gb.transpose() + mu * gb * ga.transpose();
      block.diagonal().array() += mu * ga.dot(gb);
      stiffness.block<3, 3>(3 * a, 3 * b) += weight * block;
    }
}

}  // namespace

ElementGeometry element_geometry(const std::array<Eigen::Vector3d, 4>& corners) {
  Eigen::Matrix3d edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = corners[a + 1] - corners[0];
  ElementGeometry element;
  element.volume = edges.determinant() / 6.0;
  element.gradients.rightCols<3>() = edges.inverse().transpose();
  element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
  return element;
}

ElementStiffness rest_stiffness(const ElementGeometry& geometry, const Elasticity& elasticity,
                                int order) {
  const int size = 3 * nodes_of_order(order);
  ElementStiffness stiffness = ElementStiffness::Zero(size, size);
  for (const SamplePoint& point : sample_points(order, 2)) {
    const NodeGradients gradients = node_gradients(geometry, order, point);
    const double weight = point.share * geometry.volume;
    if (elasticity.isotropic)
      add_isotropic(elasticity, gradients, weight, stiffness);
    else
      add_general(elasticity, gradients, weight, stiffness);
  }
  return stiffness;
}

}  // namespace tremolo
