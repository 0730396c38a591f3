// A cube whose mass is in its corners, for the effect of a body's size in contact.
#pragma once

#include <gtest/gtest.h>

#include "tests/support/frames/frame_models.h"

namespace tremolo::testing {

inline constexpr double kCubeHalf = 0.5;  // m, of its edge

// The basis of the cube about the origin, 2 kg, that nothing holds; it bends in 4 coordinates of
// `lowest` to `highest` rad/s.
inline BasisData corner_cube_data(double lowest = 300.0, double highest = 900.0,
                                  double nonlinearity = 0.1) {
  PointCloud cloud = random_cloud(4, true, 3);
  cloud.masses.assign(8, 0.25);
  cloud.places.clear();
  for (const double x : {-kCubeHalf, kCubeHalf})
    for (const double y : {-kCubeHalf, kCubeHalf})
      for (const double z : {-kCubeHalf, kCubeHalf}) cloud.places.emplace_back(x, y, z);
  Eigen::MatrixXd all(24, 10);
  all << rigid_fields(cloud), Eigen::MatrixXd(cloud.basis.topRows(24));
  cloud.basis = mass_orthonormal(std::move(all), cloud.masses).rightCols(4);
  BasisData data =
      basis_of(cloud, random_strain_model(spread_omega(4, lowest, highest), nonlinearity, 3), true);
  // Its faces, seen from outside; corner 4 x + 2 y + z.
  data.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return data;
}

inline Model::Pointer corner_cube(double lowest = 300.0, double highest = 900.0,
                                  double nonlinearity = 0.1) {
  Result<Model::Pointer> model = Model::from_data(corner_cube_data(lowest, highest, nonlinearity));
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

}  // namespace tremolo::testing
