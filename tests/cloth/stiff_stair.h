// Three stiff springs that soft ones couple, as in the chain of Fermi, Pasta and Ulam with
// alternating springs (Hairer, Lubich and Wanner, Geometric Numerical Integration, I.5.1): their
// energies change slowly from one to the next, and their sum hardly at all.
//
// A stair of eight particles: treads along x are structural springs, risers along y bend springs,
// which stretch with the square of how far the treads move along x, so that they couple these by a
// quartic potential. The first and the last particle are fixed. kg, N/m, m.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Core>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo::testing {

constexpr double kStairOmega = 50.0;  // 1/s, of a tread by itself
constexpr double kStairTread = 10.0, kStairRise = 1.0;

inline Result<ClothModel> stiff_stair() {
  ClothParts parts;
  parts.x.resize(24);
  parts.mass = Eigen::VectorXd::Ones(8);
  for (Eigen::Index i = 0; i < 8; ++i) {
    const auto treads = static_cast<double>(i / 2), risers = static_cast<double>((i + 1) / 2);
    parts.x.segment<3>(3 * i) = Eigen::Vector3d(kStairTread * treads, kStairRise * risers, 0.0);
  }
  parts.structural.law = {0.5 * kStairOmega * kStairOmega, 0.0};
  parts.bend.law = {4.0, 0.0};
  for (std::uint32_t i = 0; i + 1 < 8; ++i) {
    ClothSprings& springs = i % 2 == 0 ? parts.bend : parts.structural;
    springs.pairs.emplace_back(i, i + 1);
    springs.rest.push_back(i % 2 == 0 ? kStairRise : kStairTread);
  }
  Result<ClothModel> model = ClothModel::create(std::move(parts));
  if (!model) return model.error();
  const std::array<std::size_t, 2> ends{0, 7};
  if (Status s = model->pin(ends, MotionPath{}, 1e300); !s) return s.error();
  return model;
}

// All of the fast energy, 1 J, is the first tread's stretch; two treads drift slowly as a whole.
inline NodalState stair_start(const ClothModel& model) {
  NodalState state{model.parts().x, Eigen::VectorXd::Zero(24), 0.0};
  state.x[3] -= 1.0 / kStairOmega;
  state.x[6] += 1.0 / kStairOmega;
  state.v[3] = state.v[6] = 0.5;
  state.v[9] = state.v[12] = -0.3;
  return state;
}

// J, of each tread: stretch, and half its reduced mass times the square of the speed of it.
inline Eigen::Vector3d stair_energies(const NodalState& state) {
  Eigen::Vector3d energies;
  for (Eigen::Index tread = 0; tread < 3; ++tread) {
    const Eigen::Index a = 3 * (1 + 2 * tread), b = a + 3;
    const Eigen::Vector3d r = state.x.segment<3>(b) - state.x.segment<3>(a);
    const double stretch = r.norm() - kStairTread;
    const double speed = (state.v.segment<3>(b) - state.v.segment<3>(a)).dot(r.normalized());
    energies[tread] = 0.25 * (kStairOmega * kStairOmega * stretch * stretch + speed * speed);
  }
  return energies;
}

}  // namespace tremolo::testing
