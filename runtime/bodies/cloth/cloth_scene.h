// Cloths, rigid spheres and the obstacles of both, as plain values; SI units, vectors along the
// world's axes. ClothWorld (runtime/bodies/cloth/cloth_world.h) simulates them.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/math/motion.h"
#include "runtime/math/pose.h"
#include "runtime/scene/scene.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo {

// A spring and a damper: N/m, N s/m.
struct SpringLaw {
  double stiffness = 0.0;
  double damping = 0.0;
};

// Rows and columns of particles over `width` x `height`, m, from `corner` along `along` (columns)
// and `across` (rows), unit vectors at right angles.
struct ClothGrid {
  std::size_t columns = 0, rows = 0;
  double width = 1.0, height = 1.0;
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::UnitX(), across = Eigen::Vector3d::UnitY();
};

// The particle of a row and a column, both from 0; particles are numbered row by row.
inline std::size_t grid_particle(const ClothGrid& grid, std::size_t row, std::size_t column) {
  return row * grid.columns + column;
}

// Particles that are fixed, chosen at rest.
struct ClothPin {
  // Their indices; for a grid the reader converts `corner` words to indices.
  std::vector<std::size_t> particles;
  Motion motion;  // moves them from their positions
  // They are released at this time, s.
  double until = std::numeric_limits<double>::infinity();
};

// A cloth. It has either a grid or a file.
struct SceneCloth {
  std::string name = "cloth";
  ClothGrid grid;
  std::string file;  // .obj or .ply
  // Pose of the frame in which the grid or the file's vertices are, m.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  // Pins, hands and loads find places by coordinates where the cloth has this pose: of copies that
  // of the first one; empty: its own.
  std::optional<Pose> named_at = {};
  double density = 0.2;  // kg/m^2
  SpringLaw structural{1000.0, 0.01}, shear{300.0, 0.01}, bend{20.0, 0.001};
  // Drag rho of the wind, kg/m^3. The force on a triangle is 1/2 rho A |n.w| (n.w) n, where w is
  // the wind's velocity relative to it (docs/cloth.md).
  double drag = 1.2;
  double thickness = 0.005;  // least distance of particles from colliders, m
  double friction = 0.3;     // with its obstacles
  double restitution = 0.0;  // with its obstacles
  std::vector<ClothPin> pins;
  // Random displacement at the start, as a fraction of the spacing; the seed is fixed.
  double crumple = 0.0;
  // It begins at rest in its equilibrium under gravity, pins and its loads at t = 0, without wind.
  bool settled = false;

  // x of the frame, in the world.
  Eigen::Vector3d placed(const Eigen::Vector3d& x) const { return position + rotation * x; }
  // A point of the cloth's world where the cloth has the pose `named_at`.
  Eigen::Vector3d named(const Eigen::Vector3d& x) const {
    return named_at ? *named_at * (rotation.conjugate() * (x - position)) : x;
  }
};

// A rigid ball that rolls, falls and collides.
struct SceneBall {
  std::string name;
  double radius = 0.1;                                 // m
  double mass = 1.0;                                   // kg
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();      // rad/s
  bool fixed = false;                                  // it is at rest or follows its motion
  Motion motion;
  double friction = 0.3;
  double restitution = 0.3;
};

// A grab of a named cloth's particle. The particle moves from its position at the start as the
// motion maps the world, and is at the end of its path at the end of each step.
struct ClothHand {
  std::string cloth;
  std::size_t particle = 0;
  Motion motion;
  double from = 0.0;        // start of the first step, s
  double until = kForEver;  // s
};

struct ClothScene {
  std::string integrator = "implicit-euler";
  NodalOptions options;
  double duration = 10.0;  // s
  SceneGravity gravity;
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();  // m/s
  double gust = 0.0;                               // fraction of the wind that varies with gust_hz
  double gust_hz = 0.7;
  std::vector<SceneCloth> cloths;
  std::vector<SceneBall> balls;
  std::vector<SceneCollider> colliders;
  std::vector<ClothHand> hands;
};

// A cloth next to bodies of other kinds. scene: this cloth, its method, and the gravity and wind of
// the world. contact: stiffness or modulus; its margin is the cloth's thickness.
struct ClothSceneBody {
  ClothScene scene;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of all particles at the start, m/s
  // rad/s, of the whole cloth about its centre of mass at the start; not with pins.
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  ContactOptions contact;
  std::vector<std::string> probes;  // particles whose motion is recorded
  std::vector<SceneLoad> loads;

  const SceneCloth& cloth() const { return scene.cloths.front(); }
  const std::string& name() const { return cloth().name; }
};

// Errors, kContent, naming cloth, ball, collider or key: neither grid nor file, or both; sizes and
// stiffnesses out of range (negative, not finite); a mass or density that is not positive; pins and
// hands without a particle that exists; duplicate names; an unknown integrator.
Status check_scene(const ClothScene& scene);

}  // namespace tremolo
