// Random tetrahedra and motions of their control points.
#pragma once

#include <array>
#include <random>

#include <Eigen/Geometry>

#include "runtime/bodies/tets/elements/tet_element.h"

namespace tremolo::testing {

struct RandomTet {
  std::array<Eigen::Vector3d, 4> corners;
  Elasticity elasticity;
  TetElement element;
};

class TetRandom {
 public:
  explicit TetRandom(unsigned seed) : engine_(seed) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::Vector3d vector(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  Eigen::Matrix3d rotation() {
    const Eigen::Vector3d axis = vector(1.0).normalized();
    return Eigen::AngleAxisd(between(0.0, 3.14), axis).toRotationMatrix();
  }

  // A corner of a cube of 1 m with corners moved by up to 0.15 m.
  RandomTet tet(const Material& material) {
    RandomTet made;
    made.corners = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                    Eigen::Vector3d::UnitZ()};
    for (Eigen::Vector3d& x : made.corners) x += vector(0.15);
    made.elasticity = make_elasticity(material);
    made.element = make_tet_element(made.corners, made.elasticity, material.density);
    return made;
  }

  // Each coordinate of each control point moved by up to `size` m.
  NodeVectors moved(const NodeVectors& x, double size) {
    NodeVectors y = x;
    for (Eigen::Index i = 0; i < y.cols(); ++i) y.col(i) += vector(size);
    return y;
  }

 private:
  std::mt19937_64 engine_;
};

// Control points of the element at rest.
inline NodeVectors rest_points(const std::array<Eigen::Vector3d, 4>& corners, int order) {
  NodeVectors x(3, nodes_of_order(order));
  for (int a = 0; a < 4; ++a) x.col(a) = corners[a];
  for (int e = 4; e < x.cols(); ++e)
    x.col(e) = 0.5 * (corners[kTetEdges[e - 4][0]] + corners[kTetEdges[e - 4][1]]);
  return x;
}

// K x of a stiffness whose rows are 3 node + axis.
inline NodeVectors stiffness_times(const ElementStiffness& k, const NodeVectors& x) {
  NodeVectors y(3, x.cols());
  Eigen::Map<Eigen::VectorXd>(y.data(), y.size()) =
      k * Eigen::Map<const Eigen::VectorXd>(x.data(), x.size());
  return y;
}

inline Eigen::Vector3d torque_of(const NodeVectors& x, const NodeVectors& f) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    sum += Eigen::Vector3d(x.col(i)).cross(Eigen::Vector3d(f.col(i)));
  return sum;
}

// sum |x_i x f_i|: the scale for torques.
inline double torque_scale(const NodeVectors& x, const NodeVectors& f) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    sum += Eigen::Vector3d(x.col(i)).cross(Eigen::Vector3d(f.col(i))).norm();
  return sum;
}

}  // namespace tremolo::testing
