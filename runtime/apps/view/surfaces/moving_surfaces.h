// Scenes as moving surfaces, the interface of pictures and window: cloth, bodies of tetrahedra.
// Positions in m, as shown.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/material.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/math/pose.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// A surface.
struct ShownSheet {
  std::string name;
  std::span<const Triangle> triangles;  // valid until the scenes restart
  std::size_t vertices = 0;
  bool has_degrees = false;                   // its degrees are known: SheetNow
  std::vector<Eigen::Vector3d> rest = {};     // of each vertex, m, in any pose
  std::span<const Eigen::Vector2f> uvs = {};  // of each vertex; empty: no texture coordinates
  // Of each triangle, for its stress; none: it has no stress. Empty: the sheet has none.
  std::vector<std::optional<Material>> materials = {};
};

// A rigid ball, or a collider: then `collider` is set and radius is 0.
struct ShownSolid {
  std::string name;
  double radius = 0.0;  // m
  const SceneCollider* collider = nullptr;
};

// The present state of a sheet.
struct SheetNow {
  std::vector<double> positions;  // x y z of each vertex, m
  std::vector<float> normals;     // of unit length; empty: those of the triangles are used
  // Of each vertex, 0 to 1: the fraction of quadratic edges of its element; empty for cloth.
  std::vector<float> degrees;
};

class MovingSurfaces {
 public:
  virtual ~MovingSurfaces() = default;

  virtual SceneGravity gravity() const = 0;
  virtual std::vector<ShownSheet> sheets() const = 0;
  virtual std::vector<ShownSolid> solids() const = 0;
  // Overwrites `now`. sheet, solid: indices into the lists above.
  virtual void place(std::size_t sheet, SheetNow& now) const = 0;
  virtual Pose pose(std::size_t solid) const = 0;

  virtual double time() const = 0;       // s
  virtual double step_size() const = 0;  // s
  virtual std::int64_t steps() const = 0;
  virtual Status step() = 0;
  // Restarts from the beginning.
  virtual Status begin_again() = 0;
  // Lines for the window's panel.
  virtual std::vector<std::string> panel_lines() const = 0;

  // The user's hand. take() grabs the first thing that the ray hits; false if it hits nothing or
  // something that cannot be grabbed. The hand moves from the next step on. hand(): its position;
  // nothing while it is empty.
  virtual bool take(const CameraRay& ray) = 0;
  virtual void move_to(const Eigen::Vector3d& point) = 0;
  virtual void let_go() = 0;
  virtual std::optional<Eigen::Vector3d> hand() const = 0;

  // Energy given by holds since the beginning, those of the scenes' own pins included, J; nothing
  // if it is not counted.
  virtual std::optional<double> hand_work() const { return std::nullopt; }

  // Methods that the user may choose from; empty: each scene has a fixed one. chosen(): the present
  // method of each scene.
  virtual std::span<const std::string_view> methods() const { return {}; }
  virtual std::vector<std::string> chosen() const { return {}; }
  // Changes the method of one scene, or the step, s, of all. Errors, which change nothing: kUsage
  // with the reason.
  virtual Status choose(std::size_t scene, std::string_view method);
  virtual Status set_step_size(double step);

  // Records the hand from the beginning, and writes it as a scene that repeats the motion; without
  // any pull nothing is written. Errors: kUsage if these scenes do not support it.
  virtual Status record_hand();
  virtual Status write_hand(const std::string& path);
};

inline Status MovingSurfaces::choose(std::size_t, std::string_view) {
  return usage_error("the method of these scenes cannot be changed");
}
inline Status MovingSurfaces::set_step_size(double) {
  return usage_error("the step of these scenes cannot be changed");
}
inline Status MovingSurfaces::record_hand() {
  return usage_error("--record-hand applies only to bodies with a basis and to cloth");
}
inline Status MovingSurfaces::write_hand(const std::string&) {
  return record_hand();
}

}  // namespace tremolo
