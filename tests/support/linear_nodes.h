// Masses on linear springs: f = -K (x - rest) - D v, whose motion is known in closed form.
#pragma once

#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "runtime/step/nodal_system.h"

namespace tremolo::testing {

// Every node has a block with every other one. Fixed nodes move along x by `way`.
struct LinearNodes : NodalSystem {
  Eigen::MatrixXd K, D;  // 3n x 3n, symmetric
  Eigen::VectorXd masses, rest;
  std::vector<std::uint8_t> holds;
  BlockPatternPointer blocks;
  double way = 0.0;  // m/s

  LinearNodes(Eigen::MatrixXd stiffness, Eigen::MatrixXd damping, Eigen::VectorXd mass)
      : K(std::move(stiffness)), D(std::move(damping)), masses(std::move(mass)) {
    rest = Eigen::VectorXd::Zero(K.rows());
    holds.assign(masses.size(), 0);
    std::vector<NodePair> pairs;
    for (std::uint32_t i = 0; i < holds.size(); ++i)
      for (std::uint32_t j = 0; j < i; ++j) pairs.emplace_back(i, j);
    blocks = *BlockPattern::create(holds.size(), pairs);
  }
  // The same spring along x, y and z.
  static LinearNodes oscillator(double k, double d, double m) {
    return {k * Eigen::MatrixXd::Identity(3, 3), d * Eigen::MatrixXd::Identity(3, 3),
            Eigen::VectorXd::Constant(1, m)};
  }
  static LinearNodes random(Eigen::Index n, double stiffness, double damping, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    Eigen::MatrixXd a(3 * n, 3 * n);
    for (double& entry : a.reshaped()) entry = any(engine);
    Eigen::VectorXd m(n);
    for (double& mass : m) mass = 1.5 + any(engine);
    const Eigen::MatrixXd K = stiffness * (a * a.transpose());
    return {K, damping * K, m};
  }

  std::size_t size() const override { return holds.size(); }
  const Eigen::VectorXd& mass() const override { return masses; }
  std::span<const std::uint8_t> held() const override { return holds; }
  const BlockPatternPointer& pattern() const override { return blocks; }
  double load_size() const override { return 1.0; }
  void put_held(double time, Eigen::VectorXd& x) const override {
    for (std::size_t i = 0; i < holds.size(); ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      if (holds[i] != 0) x[at] = rest[at] + way * time;
    }
  }
  // The soft half is a tenth.
  static double share(ForcePart part) {
    return part == ForcePart::kAll ? 1.0 : part == ForcePart::kStiff ? 0.9 : 0.1;
  }
  void force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
             Eigen::VectorXd& f) const override {
    f.noalias() = -share(part) * (K * (x - rest) + D * v);
  }
  void add_matrix(const Eigen::MatrixXd& all, BlockMatrix& a) const {
    for (std::size_t i = 0; i < size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        a.block(blocks->find(i, j)) +=
            all.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j));
  }
  void add_tangent(const Eigen::VectorXd&, const Eigen::VectorXd&, ForcePart part, double position,
                   double velocity, double, BlockMatrix& a) const override {
    add_matrix(share(part) * (position * K + velocity * D), a);
  }
  double potential(const Eigen::VectorXd& x) const override {
    return 0.5 * (x - rest).dot(K * (x - rest));
  }
  StepWork power(const Eigen::VectorXd&, const Eigen::VectorXd& v) const override {
    return {v.dot(D * v), 0.0};
  }
  StepWork step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                      Eigen::VectorXd& f) const override {
    const Eigen::VectorXd d = x1 - x0;
    f = -(K * (0.5 * (x0 + x1) - rest) + D * d / h);
    return {d.dot(D * d) / h, 0.0};
  }
  void add_step_tangent(const Eigen::VectorXd&, const Eigen::VectorXd&, double h, double,
                        BlockMatrix& a) const override {
    add_matrix(0.5 * K + D / h, a);
  }
};

}  // namespace tremolo::testing
