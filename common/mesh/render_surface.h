// A surface as its author made it: what is drawn, with what belongs to its corners.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Vertices are split where normals or texture coordinates are: two of them may be at one position.
// Nothing is promised of the triangles: holes, repeats and crossings are the author's.
struct RenderSurface {
  std::vector<Eigen::Vector3d> vertices;   // s, m
  std::vector<Triangle> triangles;         // t, indices into vertices
  std::vector<Eigen::Vector3f> normals;    // s or none, of length 1
  std::vector<Eigen::Vector2f> uvs;        // s or none
  std::vector<Colour> colours;             // s or none
  std::vector<std::uint32_t> object_of;    // t, index into objects
  std::vector<std::uint32_t> material_of;  // t, index into materials
  std::vector<std::string> objects;        // names, each once, at least one
  std::vector<std::string> materials;      // names, each once, at least one
};

}  // namespace tremolo
