// A basis of two coordinates over five vertices: the smallest file with every section in it.
#pragma once

#include "formats/basis/basis_data.h"

namespace tremolo::testing {

inline BasisData tiny_basis() {
  BasisData data;
  data.vertex_count = 5;
  data.tetrahedron_count = 4;
  data.linear_mode_count = 1;
  data.fixed_vertex_count = 1;
  data.total_mass = 0.75;
  data.lambda.resize(2);
  data.lambda << 400.0, 90000.0;
  data.cubic = {1.5, -0.25, 0.125, 3.0};
  data.quartic = {2.0, 0.5, 1.0, -0.0625, 4.0};
  data.singular_values = {1.0, 0.0625, 0.0009765625};
  data.surface.vertex_ids = {0, 1, 2, 3};
  data.surface.rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  data.surface.rows = BasisRows::Zero(12, 2);
  for (Eigen::Index row = 3; row < 12; ++row)
    data.surface.rows.row(row) << 0.125 * static_cast<double>(row), -1.0 / static_cast<double>(row);
  data.interior.vertex_ids = {4};
  data.interior.rest = {{0.25, 0.25, 0.25}};
  data.interior.rows = BasisRows::Constant(3, 2, 0.5);
  data.triangles = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  data.fixed_vertices = {0};
  data.load.vertices = {3};
  data.load.forces = {{0.0, -2.0, 0.5}};
  data.provenance = "{\"generator\": \"by hand\", \"mass_orthonormality_error\": 0.0}\n";
  return data;
}

}  // namespace tremolo::testing
