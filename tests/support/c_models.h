// Models for tests of the C interface.
#pragma once

#include "formats/basis/basis_writer.h"
#include "runtime/tremolo.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo::testing {

// The model of a cloud of mass points with four coordinates, 60 to 300 rad/s, strongly nonlinear,
// whose frame may be free. Null where it cannot be made: tremolo_last_error() says why.
inline tremolo_model* load_cloud_model() {
  const StrainModel strain = random_strain_model(spread_omega(4, 60.0, 300.0), 0.2, 3);
  const auto bytes = encode_basis(basis_of(random_cloud(4, true, 3), strain, true));
  tremolo_model* model = nullptr;
  if (bytes) tremolo_model_load_memory(bytes->data(), bytes->size(), 0, &model);
  return model;
}

}  // namespace tremolo::testing
