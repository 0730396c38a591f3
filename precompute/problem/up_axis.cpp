#include "precompute/problem/up_axis.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "common/mesh/surface_mesh.h"

namespace tremolo {
namespace {

// A plane foot lies within kPlane of the extent, is level to within 18 degrees (cosine kLevel) and
// covers at least kLeastFoot of the bounding box's section; competing ends must be below kClearly
// of it.
constexpr double kPlane = 0.01;
constexpr double kLevel = 0.95;
constexpr double kLeastFoot = 0.01;
constexpr double kClearly = 0.25;

template <class Vector>
Vector turned(const Vector& x) {
  return {x[0], -x[2], x[1]};
}

// Returns whether the selector, or a part of it, takes the low end of z and none of it mentions y.
bool takes_low_z(const Selector& selector) {
  bool low_z = false, other = false;
  const auto look = [&](const Selector& one) {
    const auto* half = std::get_if<SelectHalfSpace>(&one.choice);
    if (half == nullptr) return;
    const bool below = half->comparison == SelectHalfSpace::Comparison::kLess ||
                       half->comparison == SelectHalfSpace::Comparison::kLessEqual;
    low_z |= half->axis == 2 && below;
    other |= half->axis == 1;
  };
  look(selector);
  for (const Selector& more : selector.further) look(more);
  return low_z && !other;
}

// Returns the area of the plane end along an axis, as a share of the bounding box's section.
double plane_end(const SurfaceMesh& surface, const BoundingBox& box, int axis, bool low) {
  const Eigen::Vector3d extent = box.high - box.low;
  const double section = extent.prod() / extent[axis];
  const double from = low ? box.low[axis] : box.high[axis];
  double area = 0;
  for (const Triangle& t : surface.triangles) {
    const auto at = [&](std::size_t i) -> const Eigen::Vector3d& { return surface.vertices[t[i]]; };
    const Eigen::Vector3d doubled = (at(1) - at(0)).cross(at(2) - at(0));
    const double level = (low ? -1.0 : 1.0) * doubled[axis];
    bool near = level > kLevel * doubled.norm();
    for (std::size_t i = 0; i < 3; ++i)
      near = near && std::abs(at(i)[axis] - from) <= kPlane * extent[axis];
    if (near) area += 0.5 * level;
  }
  return area / section;
}

bool stands_on_y(const TetMesh& mesh) {
  const SurfaceMesh surface = boundary_mesh(mesh);
  const BoundingBox box = bounding_box(surface.vertices);
  if (!((box.high - box.low).minCoeff() > 0)) return false;
  const double foot = plane_end(surface, box, 1, true);
  return foot >= kLeastFoot && plane_end(surface, box, 1, false) < kClearly * foot &&
         plane_end(surface, box, 2, true) < kClearly * foot;
}

}  // namespace

void turn_y_to_z(TetMesh& mesh) {
  for (Eigen::Vector3d& x : mesh.vertices) x = turned(x);
}

void turn_y_to_z(RenderSurface& surface) {
  for (Eigen::Vector3d& x : surface.vertices) x = turned(x);
  for (Eigen::Vector3f& n : surface.normals) n = turned(n);
  if (surface.rig == nullptr) return;
  SurfaceRig rig = *surface.rig;
  for (RigBone& bone : rig.bones) {
    bone.head = turned(bone.head);
    bone.tail = turned(bone.tail);
  }
  for (RigClip& clip : rig.clips)
    for (RigPose& pose : clip.poses) {
      pose.position = turned(pose.position);
      pose.rotation.vec() = turned(Eigen::Vector3d(pose.rotation.vec()));
    }
  surface.rig = std::make_shared<const SurfaceRig>(std::move(rig));
}

void turn_y_to_z(std::vector<FileMaterial>& materials) {
  for (FileMaterial& each : materials) {
    if (!each.material.orthotropic) continue;
    Eigen::Matrix3d& axes = each.material.orthotropic->axes;
    for (int axis = 0; axis < 3; ++axis) axes.col(axis) = turned(Eigen::Vector3d(axes.col(axis)));
  }
}

std::string side_hint(const std::vector<Selector>& selectors, const TetMesh& mesh,
                      bool y_by_format) {
  const auto found = std::find_if(selectors.begin(), selectors.end(), takes_low_z);
  if (found == selectors.end() || (!y_by_format && !stands_on_y(mesh))) return "";
  return found->text + " takes the body's side, if y points up: " +
         (y_by_format ? "it does by the file's format" : "it stands on a plane foot along y") +
         ". --up y turns it so that z points up; or take what is low along y";
}

bool has_y_up(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  constexpr std::array<std::string_view, 4> kFormats = {".gltf", ".glb", ".x3d", ".x3db"};
  return std::find(kFormats.begin(), kFormats.end(), extension) != kFormats.end();
}

}  // namespace tremolo
