// Files of corotated tetrahedra: a mesh with its materials and fixed vertices, the drawn surface
// with its weights on the mesh, and the distances at rest for contact (docs/tets-format.md). They
// do not contain stiffness: the engine computes it with the formulas of the precomputation
// (common/elements/), in some microseconds per element.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/distance/distance_grid.h"
#include "common/elements/elasticity.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A surface of triangles that follows tetrahedra: at rest vertex v is at sum_c weights[v]_c X_c,
// with the corners of tetrahedra[v]. The weights are barycentric coordinates, and may be somewhat
// outside [0, 1]; their sum is 1. uvs: one per vertex, or empty.
struct TetsSurface {
  std::vector<Eigen::Vector3d> vertices;  // m, at rest
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> tetrahedra;
  std::vector<Eigen::Vector4d> weights;
  std::vector<Eigen::Vector2f> uvs;
  std::vector<VertexId> sources;  // as RenderSurface has them
};

// mesh: linear, positively oriented. held: ascending. nodes, distances: of the surface at rest, m,
// negative inside; none: the body touches no other. provenance: a JSON object; empty: none.
struct TetsData {
  TetMesh mesh;
  MaterialTable materials;
  std::vector<VertexId> held;
  TetsSurface surface;
  GridNodes nodes;
  std::vector<float> distances;
  std::string provenance;
};

// The bytes of the file; the same data give the same bytes. Errors (kContent): those of
// read_tets().
Result<std::vector<std::byte>> encode_tets(const TetsData& data);
// The same, written under a temporary name and renamed to `path`. Errors: also kSystem.
Status write_tets(const std::string& path, const TetsData& data);

struct TetsFile {
  TetMesh mesh;
  MaterialTable materials;
  std::vector<VertexId> held;
  TetsSurface surface;
  std::optional<DistanceGrid> grid;
  std::string provenance;
};

// Reads with distrust: header, table, shapes, checksums, every index, every number. Errors name the
// file and the section: kContent, and kSystem for a file that cannot be read.
Result<TetsFile> read_tets(const std::string& path);
// `name` is for errors.
Result<TetsFile> read_tets(std::span<const std::byte> bytes, const std::string& name = "memory");

}  // namespace tremolo
