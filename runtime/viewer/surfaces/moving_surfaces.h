// Scenes of which nothing is known but surfaces that move: cloth, bodies of tetrahedra. Pictures
// and the window ask for what is below; places are m, as shown.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "runtime/frames/pose.h"
#include "runtime/scene/scene.h"
#include "runtime/viewer/camera/camera.h"

namespace tremolo {

// A surface: its name, its triangles, valid until the scenes begin again, and how many vertices
// they are of. numbered: each vertex has a number, 0 to 1, to be coloured by.
struct ShownSheet {
  std::string name;
  std::span<const Triangle> triangles;
  std::size_t vertices = 0;
  bool numbered = false;
};

// A rigid ball, or a collider: then `collider` is set and radius is 0.
struct ShownSolid {
  std::string name;
  double radius = 0.0;  // m
  const SceneCollider* collider = nullptr;
};

// Places of a sheet now: x y z ... of each vertex; normals of length one, none: those of the
// triangles are taken; numbers, none unless it is numbered.
struct SheetNow {
  std::vector<double> positions;
  std::vector<float> normals;
  std::vector<float> numbers;
};

class MovingSurfaces {
 public:
  virtual ~MovingSurfaces() = default;

  virtual SceneGravity gravity() const = 0;
  virtual std::vector<ShownSheet> sheets() const = 0;
  virtual std::vector<ShownSolid> solids() const = 0;
  // Overwrites `now`. sheet, solid: as numbered by the lists above.
  virtual void place(std::size_t sheet, SheetNow& now) const = 0;
  virtual Pose pose(std::size_t solid) const = 0;

  virtual double time() const = 0;       // s
  virtual double step_size() const = 0;  // s
  virtual std::int64_t steps() const = 0;
  virtual Status step() = 0;
  // From the beginning anew.
  virtual Status begin_again() = 0;
  // Lines for the window's panel.
  virtual std::vector<std::string> told() const = 0;

  // The user's hand. take() holds what the ray meets first, false where that is nothing or cannot
  // be held; it is moved from the next step on. hand(): where it is; nothing while it is empty.
  virtual bool take(const CameraRay& ray) = 0;
  virtual void move_to(const Eigen::Vector3d& point) = 0;
  virtual void let_go() = 0;
  virtual std::optional<Eigen::Vector3d> hand() const = 0;

  // What holds gave since the beginning, the scenes' own pins among them, J; nothing where that is
  // not counted.
  virtual std::optional<double> hand_work() const { return std::nullopt; }

  // Methods that the user may choose from; none: the scenes have one each that stays. chosen(): of
  // each scene by which it is stepped.
  virtual std::span<const std::string_view> methods() const { return {}; }
  virtual std::vector<std::string> chosen() const { return {}; }
  // Another method of one scene, another step, s, of all. Errors, and nothing is changed: kUsage
  // where they are refused, with the reason.
  virtual Status choose(std::size_t scene, std::string_view method);
  virtual Status set_step_size(double step);

  // A hand is recorded from the beginning on, and written at the end as a scene that does the same
  // again; where nothing was pulled nothing is written. Errors: kUsage where these scenes cannot
  // be.
  virtual Status record_hand();
  virtual Status write_hand(const std::string& path);
};

inline Status MovingSurfaces::choose(std::size_t, std::string_view) {
  return usage_error("the method of these scenes stays as it is");
}
inline Status MovingSurfaces::set_step_size(double) {
  return usage_error("the step of these scenes stays as it is");
}
inline Status MovingSurfaces::record_hand() {
  return usage_error("--record-hand is of bodies with a basis and of cloth");
}
inline Status MovingSurfaces::write_hand(const std::string&) {
  return record_hand();
}

}  // namespace tremolo
