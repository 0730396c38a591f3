// Sheets of cloth for tests of their contact with bodies of other kinds.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tests/mixed/mixed_bodies.h"

namespace tremolo::testing {

// A square sheet of cloth, flat, with its middle at a point.
struct Sheet {
  std::string integrator = "implicit-euler";
  std::size_t particles = 9;  // along each edge
  double width = 0.3;         // m
  double density = 0.2;       // kg/m^2
  double thickness = 0.004;   // m
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  SpringLaw structural{200.0, 0.02}, shear{60.0, 0.02}, bend{2.0, 0.002};
};

inline ClothScene sheet_scene(const Sheet& sheet, const MixedKind& kind) {
  ClothScene scene;
  scene.integrator = sheet.integrator;
  scene.options.step = kind.step;
  scene.options.tolerance = 1e-9;
  scene.gravity.values = {kind.gravity};
  SceneCloth cloth;
  cloth.name = "sheet";
  cloth.grid.columns = cloth.grid.rows = sheet.particles;
  cloth.grid.width = cloth.grid.height = sheet.width;
  cloth.grid.corner = sheet.middle - Eigen::Vector3d(0.5 * sheet.width, 0.5 * sheet.width, 0.0);
  cloth.density = sheet.density;
  cloth.thickness = sheet.thickness;
  cloth.friction = kind.friction;
  cloth.restitution = kind.restitution;
  cloth.structural = sheet.structural;
  cloth.shear = sheet.shear;
  cloth.bend = sheet.bend;
  cloth.drag = 0.0;
  scene.cloths = {cloth};
  return scene;
}

inline ClothBody sheet_body(const Sheet& sheet, const MixedKind& kind) {
  Result<ClothBody> body = ClothBody::create(sheet_scene(sheet, kind), sheet.velocity);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

// Energy that a cloth has lost or got by its method and its dampers since the start, J.
inline double own_energy(const ClothBody& body) {
  return body.work().numerical - body.work().damped + body.work().wind + body.work().gravity;
}

// Errors of the sums over all bodies in several steps.
struct WorstErrors {
  double linear = 0.0, angular = 0.0, energy = 0.0;  // kg m/s, N m s, J
  double start = 0.0;                                // J
  int touched = 0, cut = 0;
};

// Energy of the tetrahedra's method since the start is known only as the change without a cause.
inline WorstErrors follow(MixedWorld& world, int steps) {
  WorstErrors worst;
  const MixedSum start = sum_of(world);
  worst.start = start.energy;
  double taken = 0.0, own = 0.0;
  for (int i = 0; i < steps; ++i) {
    double before = 0.0;
    for (std::size_t k = 0; k < world.size(); ++k)
      if (TetBody* tets = world.tets(k)) before = tets->kinetic_energy() + tets->elastic_energy();
    const Status made = world.step();
    EXPECT_TRUE(made) << i << made.error().message;
    if (!made) break;
    worst.cut += world.report().cut;
    double cloth = 0.0;
    for (std::size_t k = 0; k < world.size(); ++k) {
      taken += world.account(k).lost + world.account(k).friction_loss;
      if (const ClothBody* body = world.cloth(k)) {
        cloth = own_energy(*body);
        worst.touched += world.account(k).active;
      }
      if (TetBody* tets = world.tets(k))
        own += tets->kinetic_energy() + tets->elastic_energy() - before - world.account(k).work;
    }
    const MixedSum now = sum_of(world);
    worst.linear = std::max(worst.linear, (now.linear - start.linear).norm());
    worst.angular = std::max(worst.angular, (now.angular - start.angular).norm());
    worst.energy =
        std::max(worst.energy, std::abs(now.energy + taken - own - cloth - start.energy));
  }
  return worst;
}

}  // namespace tremolo::testing
