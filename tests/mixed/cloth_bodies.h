// Sheets of cloth for tests of their contact with bodies of other kinds.
#pragma once

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

}  // namespace tremolo::testing
