// A model of V = 1/2 q^T Lambda q with any number of coordinates, for tests.
#pragma once

#include <gtest/gtest.h>

#include "runtime/model.h"
#include "tests/support/sample_basis.h"

namespace tremolo::testing {

// A model without cubic and quartic terms. omega: rad/s, ascending.
inline Model::Pointer linear_model(const Eigen::VectorXd& omega) {
  BasisData data = sample_basis(random_strain_model(Eigen::VectorXd::Ones(1), 0.0, 1));
  data.lambda = omega.cwiseAbs2();
  data.cubic.clear();
  data.quartic.clear();
  data.linear_mode_count = static_cast<std::uint64_t>(omega.size());
  data.surface.rows = BasisRows::Random(data.surface.rows.rows(), omega.size());
  data.interior.rows = BasisRows::Random(data.interior.rows.rows(), omega.size());
  Result<Model::Pointer> model = Model::from_data(data, {.linear = true});
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

}  // namespace tremolo::testing
