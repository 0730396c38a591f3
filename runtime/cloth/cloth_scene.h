// Cloths, rigid spheres and what they touch, as plain values; SI units, vectors along the world's
// axes. ClothWorld (runtime/cloth/cloth_world.h) makes them go.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/nodal/nodal_integrator.h"
#include "runtime/scene/motion.h"
#include "runtime/scene/scene.h"

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

// The particle of a row and a column, counted from 0: row behind row.
inline std::size_t grid_particle(const ClothGrid& grid, std::size_t row, std::size_t column) {
  return row * grid.columns + column;
}

// Particles that are held, chosen at rest: ids; on a grid `corner` words are turned into ids by the
// reader. motion: moves them from where they are; until: s, they are let go then.
struct ClothPin {
  std::vector<std::size_t> particles;
  Motion motion;
  double until = std::numeric_limits<double>::infinity();
};

// grid, or file (.obj, .ply): one of both. position: added to the file's vertices, m. density:
// kg/m^2. thickness: how far particles stay off colliders, m. friction, restitution: towards what
// it touches. drag: kg/m^3 s/m..., see docs/cloth.md: force of the wind on a triangle, 1/2 drag A
// |n.w| (n.w) n, drag kg/m^3, w the wind's velocity relative to it.
struct SceneCloth {
  std::string name = "cloth";
  ClothGrid grid;
  std::string file;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double density = 0.2;
  SpringLaw structural{1000.0, 0.01}, shear{300.0, 0.01}, bend{20.0, 0.001};
  double drag = 1.2;
  double thickness = 0.005;
  double friction = 0.3;
  double restitution = 0.0;
  std::vector<ClothPin> pins;
  double crumple = 0.0;  // a share of the spacing by which particles are off at the start, seeded
};

// A rigid ball: rolls, falls and collides; fixed: it stays, or goes as its motion does.
struct SceneBall {
  std::string name;
  double radius = 0.1;
  double mass = 1.0;  // kg
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  bool fixed = false;
  Motion motion;
  double friction = 0.3;
  double restitution = 0.3;
};

// A hand that holds a particle of a cloth, named, from the step that begins at `from`, s, to
// `until`: where it is then, and from there on as the motion maps the world. It is on its way's end
// at the end of each step.
struct ClothHand {
  std::string cloth;
  std::size_t particle = 0;
  Motion motion;
  double from = 0.0;
  double until = kForEver;
};

struct ClothScene {
  std::string integrator = "implicit-euler";
  NodalOptions options;
  double duration = 10.0;  // s
  SceneGravity gravity;
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();  // m/s
  double gust = 0.0;  // a share of the wind that comes and goes, with gust_hz
  double gust_hz = 0.7;
  std::vector<SceneCloth> cloths;
  std::vector<SceneBall> balls;
  std::vector<SceneCollider> colliders;
  std::vector<ClothHand> hands;
};

// Errors, kContent, naming cloth, ball, collider or key: none of both grid and file, or both,
// sizes and stiffnesses out of range (negative, not finite), a mass or density that is not
// positive, pins and hands that name no particle, names that stand twice, an integrator that is
// none.
Status check_scene(const ClothScene& scene);

}  // namespace tremolo
