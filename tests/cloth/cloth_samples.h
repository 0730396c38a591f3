// Cloths and chains for the tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_scene.h"

namespace tremolo::testing {

inline SceneCloth sample_sheet(std::size_t columns, std::size_t rows) {
  SceneCloth cloth;
  cloth.grid.columns = columns;
  cloth.grid.rows = rows;
  cloth.density = 0.2;
  cloth.structural = {200.0, 0.0};
  cloth.shear = {60.0, 0.0};
  cloth.bend = {5.0, 0.0};
  cloth.drag = 0.0;
  return cloth;
}

// A free sheet of a square metre in the level z = 0, and a ball of 0.1 kg.
inline ClothScene sheet_and_ball(const Eigen::Vector3d& place) {
  ClothScene scene;
  SceneCloth cloth = sample_sheet(14, 14);
  cloth.structural.damping = cloth.shear.damping = 0.01;
  cloth.grid.corner = {-0.5, -0.5, 0.0};
  scene.cloths = {cloth};
  SceneBall ball;
  ball.name = "ball";
  ball.radius = 0.2;
  ball.mass = 0.1;
  ball.position = place;
  scene.balls = {ball};
  return scene;
}

inline ClothModel sample_model(const SceneCloth& cloth) {
  Result<ClothParts> parts = make_grid_cloth(cloth);
  EXPECT_TRUE(parts);
  Result<ClothModel> model = ClothModel::create(std::move(*parts));
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

// n + 1 masses along `way` with a spring of stiffness k, damping d and rest length `rest` between
// each and the next.
inline ClothParts sample_chain(std::size_t springs, const Eigen::Vector3d& way, double rest,
                               double mass, SpringLaw law) {
  ClothParts parts;
  const Eigen::Index n = springs + 1;
  parts.x.resize(3 * n);
  parts.mass = Eigen::VectorXd::Constant(n, mass);
  parts.structural.law = law;
  for (Eigen::Index i = 0; i < n; ++i) {
    parts.x.segment<3>(3 * i) = static_cast<double>(i) * way;
    if (i == 0) continue;
    parts.structural.pairs.emplace_back(static_cast<std::uint32_t>(i - 1),
                                        static_cast<std::uint32_t>(i));
    parts.structural.rest.push_back(rest);
  }
  return parts;
}

inline Eigen::VectorXd random_numbers(Eigen::Index size, double scale, unsigned seed) {
  std::mt19937 random(seed);
  Eigen::VectorXd x(size);
  for (double& value : x)
    value = scale * (2.0 * (static_cast<double>(random()) / 4294967295.0) - 1.0);
  return x;
}

}  // namespace tremolo::testing
