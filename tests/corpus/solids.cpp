// Closed surfaces, alone and together.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "tests/corpus/corpus.h"
#include "tests/corpus/files.h"
#include "tests/corpus/shapes.h"

namespace tremolo::corpus {
namespace {

// A cube of side 1 with its low corner at `low`.
Shape cube(const Vector3d& low, int cells = 1) {
  return box(low, low + Vector3d::Ones(), {cells, cells, cells});
}

// A cylinder as a program for construction saves it: long triangles from rim to rim, fans for ends.
Shape cad_cylinder() {
  return triangulated(cylinder(0.2, 2, 64, 1));
}

std::string scene_bytes() {
  const std::vector<Shape> parts = {cube({0, 0, 0}, 2), sphere(2), cylinder(0.3, 1.5, 24, 3)};
  return gltf_bytes(parts, {{"base", 0, R"("scale":[4,4,0.5],"translation":[-2,-2,-0.4])"},
                            {"column", 2, R"("translation":[-1,-1,0])"},
                            {"column", 2, R"("translation":[1,1,0],"scale":[-1,1,1])"},
                            {"leaning", 2, R"("rotation":[0.130526,0,0,0.991445])"},
                            {"ball", 1, R"("translation":[1,-1,0.5],"scale":[0.6,0.6,0.6])"}});
}

}  // namespace

std::vector<Entry> good_surfaces() {
  return {
      {"sphere.obj", "a clean sphere", "mesh", obj_bytes(sphere(3))},
      {"cube.stl", "a cube with sharp edges, text", "mesh", stl_bytes(cube({0, 0, 0}, 4), false)},
      {"torus.ply", "a torus of quads", "mesh", ply_bytes(torus(1, 0.35, 48, 24), true)},
      {"bracket.off", "a bent bracket with two holes (genus 2)", "mesh", off_bytes(bracket())},
      {"star_prism.obj", "a prism whose ends are one concave polygon each", "mesh",
       obj_bytes(prism(star(6, 1, 0.5), 0.6))},
      {"cad_cylinder.stl", "a cylinder of long thin triangles, as CAD exports it", "mesh",
       stl_bytes(cad_cylinder(), true)},
      {"scene.gltf", "a scene: five placed parts, three materials, one mirrored", "mesh",
       scene_bytes()},
  };
}

std::vector<Entry> several_bodies() {
  const Shape unit = cube({0, 0, 0}, 2);
  const double diagonal = 1;
  const Shape touching_edge = joined(unit, moved(unit, {diagonal, diagonal, 0}));
  const Shape touching_corner = joined(unit, moved(unit, {1, 1, 1}));
  Shape crumbs = sphere(3);
  Dice dice(30);
  for (int i = 0; i < 30; ++i) {
    const double size = dice.between(0.005, 0.02);
    crumbs = joined(crumbs, moved(scaled(sphere(0), size), dice.arrow(1.2, 2)));
  }
  const auto plate = [](double x, double y, double z) {
    return box({x, y, z}, {x + 1, y + 1, z + 0.2}, {4, 4, 1});
  };
  return {
      {"two_bodies.obj", "two closed bodies apart", "mesh",
       obj_bytes(joined(sphere(2), moved(cube({0, 0, 0}, 3), {2, 0, 0})))},
      {"touching_face.stl", "two cubes with one face in common, both there", "mesh",
       stl_bytes(joined(unit, moved(unit, {1, 0, 0})), true)},
      {"shifted_face.obj", "two cubes that touch in a part of a face", "mesh",
       obj_bytes(joined(unit, moved(unit, {1, 0.3, 0.4})))},
      {"touching_edge.off", "two cubes with an edge in common", "either", off_bytes(touching_edge)},
      {"touching_edge_welded.off", "the same, the edge there once: four faces at it", "either",
       off_bytes(welded(touching_edge, 1e-6))},
      {"touching_corner.ply", "two cubes with a corner in common", "either",
       ply_bytes(touching_corner, false)},
      {"overlapping.stl", "a ball that sits half in a cube", "mesh",
       stl_bytes(joined(cube({0, 0, 0}, 4), moved(scaled(sphere(2), 0.4), {0.5, 0.5, 1})), true)},
      {"cavity.ply", "a ball with a hollow: the inner shell faces inwards", "mesh",
       ply_bytes(joined(sphere(3), flipped(scaled(sphere(2), 0.5))), true)},
      {"cavity_wrong.ply", "the same, but the inner shell faces outwards", "mesh",
       ply_bytes(joined(sphere(3), scaled(sphere(2), 0.5)), true)},
      {"crumbs.stl", "a ball with thirty crumbs about it", "mesh", stl_bytes(crumbs, true)},
      {"two_scales.obj", "a ball and another a thousandth of its size", "mesh",
       obj_bytes(joined(sphere(3), moved(scaled(sphere(2), 1e-3), {2, 0, 0})))},
      {"plates.ply", "three plates on one another, shifted, faces in one plane", "mesh",
       ply_bytes(joined(joined(plate(0, 0, 0), plate(0.3, 0.4, 0.2)), plate(0.1, -0.2, 0.4)),
                 true)},
      {"overlapping_plates.ply", "three plates that overlap in one plane", "mesh",
       ply_bytes(joined(joined(plate(0, 0, 0), plate(0.3, 0.4, 0)), plate(0.1, -0.2, 0)), true)},
  };
}

}  // namespace tremolo::corpus
