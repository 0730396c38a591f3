// Bytes of basis files for tests: reading, changing, making the checksums right again.
#pragma once

#include <gtest/gtest.h>

#include "formats/basis/basis_layout.h"
#include "formats/basis/basis_reader.h"
#include "tests/support/section_bytes.h"

namespace tremolo::testing {

inline Result<BasisData> decode(const Bytes& bytes) {
  Result<BasisReader> reader = BasisReader::from_memory(bytes);
  if (!reader) return reader.error();
  if (Status status = reader->verify_all(); !status) return status.error();
  return read_basis(*reader);
}

inline void expect_equal(const BasisData& a, const BasisData& b) {
  EXPECT_EQ(a.vertex_count, b.vertex_count);
  EXPECT_EQ(a.tetrahedron_count, b.tetrahedron_count);
  EXPECT_EQ(a.linear_mode_count, b.linear_mode_count);
  EXPECT_EQ(a.fixed_vertex_count, b.fixed_vertex_count);
  EXPECT_EQ(a.rigid_mode_count, b.rigid_mode_count);
  EXPECT_EQ(a.total_mass, b.total_mass);
  EXPECT_EQ(a.lambda, b.lambda);
  EXPECT_EQ(a.cubic, b.cubic);
  EXPECT_EQ(a.quartic, b.quartic);
  EXPECT_EQ(a.singular_values, b.singular_values);
  EXPECT_EQ(a.surface.vertex_ids, b.surface.vertex_ids);
  EXPECT_EQ(a.surface.rest, b.surface.rest);
  EXPECT_EQ(a.surface.rows, b.surface.rows);
  EXPECT_EQ(a.interior.vertex_ids, b.interior.vertex_ids);
  EXPECT_EQ(a.interior.rest, b.interior.rest);
  EXPECT_EQ(a.interior.rows, b.interior.rows);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.fixed_vertices, b.fixed_vertices);
  EXPECT_EQ(a.load.vertices, b.load.vertices);
  EXPECT_EQ(a.load.forces, b.load.forces);
  EXPECT_EQ(a.provenance, b.provenance);
}

inline void expect_no_field_is_trusted(const Bytes& bytes) {
  expect_no_field_is_trusted(bytes, [](const Bytes& file) { return bool(decode(file)); });
}

inline void expect_every_damaged_byte_is_noticed(const Bytes& bytes) {
  expect_every_damaged_byte_is_noticed(bytes, [](const Bytes& file) { return bool(decode(file)); });
}

}  // namespace tremolo::testing
