// A surface as its author made it, for drawing, with attributes of its corners.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The skeleton that a surface's author gave it: bones, weights, recorded motions.
inline constexpr std::int32_t kNoParent = -1;

struct RigBone {
  std::string name;                     // each once
  std::int32_t parent = kNoParent;      // a bone before this one
  Eigen::Vector3d head{0.0, 0.0, 0.0};  // at rest, m
  Eigen::Vector3d tail{0.0, 0.0, 0.0};  // its first child's head, or its own, m
};

// A part of a vertex that a bone carries; the parts of a vertex sum to 1.
struct RigWeight {
  std::int32_t vertex = 0;  // of the surface
  std::uint32_t bone = 0;
  float weight = 0.0F;
};

// A rigid motion from rest, in the surface's coordinates: x -> rotation x + position.
struct RigPose {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  // m
  Eigen::Quaterniond rotation{1.0, 0.0, 0.0, 0.0};
};

struct RigClip {
  std::string name;
  std::vector<double> times;   // s, ascending
  std::vector<RigPose> poses;  // of all bones, for each frame
};

struct SurfaceRig {
  std::vector<RigBone> bones;      // parents before children, at least one
  std::vector<RigWeight> weights;  // ascending by vertex, then by bone
  std::vector<RigClip> clips;
};

// Checks indices, order and sizes for a surface of `vertices`, that all numbers are finite, and
// that the weights of each vertex sum to 1 within a thousandth.
bool rig_holds(const SurfaceRig& rig, std::size_t vertices);

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
  // s or empty: the vertex of the author's file that each vertex is, or is a copy of. The n
  // vertices of the file are first, each as itself. Empty: there are no copies.
  std::vector<VertexId> sources;
  std::shared_ptr<const SurfaceRig> rig;  // the skeleton in its file, or null

  // Number of the file's vertices, n.
  std::size_t authored() const {
    std::size_t n = sources.size();
    while (n > 0 && sources[n - 1] != static_cast<VertexId>(n - 1)) --n;
    return sources.empty() ? vertices.size() : n;
  }
  // Whether `sources` is as it should be.
  bool sources_hold() const {
    if (sources.empty()) return true;
    if (sources.size() != vertices.size()) return false;
    const std::size_t n = authored();
    for (std::size_t v = 0; v < sources.size(); ++v)
      if (v < n ? sources[v] != static_cast<VertexId>(v)
                : sources[v] < 0 || static_cast<std::size_t>(sources[v]) >= n)
        return false;
    return true;
  }
};

}  // namespace tremolo
