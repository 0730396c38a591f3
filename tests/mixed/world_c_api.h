// The fixture of the tests of worlds from C: a cube, or a square of cloth, of each kind.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/tremolo_scene.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

constexpr double kWorldStep = 0.002, kFall = 9.81, kHalfEdge = 0.05;

// A cube of 0.1 m, of each kind; the cloth is a square of that size.
enum class CubeKind { kReduced, kRigid, kSoft, kCloth };
constexpr std::array kKinds = {CubeKind::kReduced, CubeKind::kRigid, CubeKind::kSoft,
                               CubeKind::kCloth};
[[maybe_unused]] constexpr std::array kSolids = {CubeKind::kReduced, CubeKind::kRigid,
                                                 CubeKind::kSoft};

class WorldCApi : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = testing::fresh_folder();
    TetMesh mesh = box_mesh({2, 2, 2}, {2 * kHalfEdge, 2 * kHalfEdge, 2 * kHalfEdge});
    for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(kHalfEdge);
    write_veg(folder_ + "/cube.veg", mesh);
    for (const char* what :
         {"tets cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none -o cube.tets",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
          "--order 1 -o cube.tremolo",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix 'z<-0.049' --linear-modes 6 "
          "--modes 9 --order 1 -o held.tremolo"}) {
      const ProgramResult made = run_program(folder_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override {
    const double half[3] = {kHalfEdge, kHalfEdge, kHalfEdge};
    ASSERT_EQ(tremolo_model_load(path("cube.tremolo").c_str(), 0, &model_), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_box(half, &box_), TREMOLO_OK);
    ASSERT_EQ(tremolo_collider_plane(&plane_), TREMOLO_OK);
    tremolo_placed_collider_init(&floor_, plane_);
    floor_.friction = 0.5;
    floor_.restitution = 0.0;
  }
  void TearDown() override {
    tremolo_set_log(nullptr, nullptr);
    for (tremolo_world* world : worlds_) tremolo_world_destroy(world);
    tremolo_model_release(model_);
    tremolo_collider_destroy(box_);
    tremolo_collider_destroy(plane_);
  }

  static std::string path(const std::string& name) { return folder_ + "/" + name; }

  // A world with a box far away, which moves alone, and with a floor or without.
  tremolo_world* make_world(bool with_floor, std::uint32_t threads = 1) {
    tremolo_scene* scene = nullptr;
    EXPECT_EQ(tremolo_scene_create(kWorldStep, &scene), TREMOLO_OK);
    tremolo_scene_body place = at("far", {50.0, 0.0, 500.0});
    EXPECT_EQ(tremolo_scene_add_rigid(scene, &place, box_, 1.0), TREMOLO_OK);
    if (with_floor) {
      EXPECT_EQ(tremolo_scene_add_collider(scene, &floor_), TREMOLO_OK);
    }
    return of(scene, threads);
  }
  tremolo_world* of(tremolo_scene* scene, std::uint32_t threads = 1) {
    tremolo_world* world = nullptr;
    EXPECT_EQ(tremolo_world_create(scene, threads, &world), TREMOLO_OK) << tremolo_last_error();
    tremolo_scene_destroy(scene);
    return worlds_.emplace_back(world);
  }

  static tremolo_scene_body at(const char* name, const Eigen::Vector3d& position) {
    tremolo_scene_body place;
    tremolo_scene_body_init(&place);
    place.name = name;
    for (int k = 0; k < 3; ++k) place.position[k] = position[k];
    place.friction = 0.5;
    place.restitution = 0.0;
    place.stiffness = 200.0;
    return place;
  }

  // The description of a body of a kind for tremolo_scene_add_* (a scene) or tremolo_world_add_*.
  template <class Reduced, class Rigid, class Tets, class Cloth>
  tremolo_status add(CubeKind kind, tremolo_scene_body place, const Reduced& reduced,
                     const Rigid& rigid, const Tets& tets, const Cloth& cloth) {
    if (kind == CubeKind::kReduced) {
      tremolo_body_options method;
      tremolo_body_options_init(&method);
      method.frame = TREMOLO_FREE;
      method.beta = 0.002;
      return reduced(place, method);
    }
    if (kind == CubeKind::kRigid) return rigid(place);
    if (kind == CubeKind::kSoft) {
      tremolo_tets_options options;
      tremolo_tets_options_init(&options);
      const std::string file = path("cube.tets");
      options.file = file.c_str();
      options.method = "midpoint";
      options.beta = 0.002;
      return tets(place, options);
    }
    tremolo_cloth_options sheet;
    tremolo_cloth_options_init(&sheet);
    sheet.columns = sheet.rows = 5;
    sheet.width = sheet.height = 2.0 * kHalfEdge;
    for (int k = 0; k < 3; ++k) sheet.corner[k] = place.position[k] - (k < 2 ? kHalfEdge : 0.0);
    sheet.density = 10.0;
    sheet.drag = 0.0;
    sheet.stiffness[0] = 2000.0;
    sheet.stiffness[1] = 600.0;
    sheet.stiffness[2] = 20.0;
    sheet.damping[0] = sheet.damping[1] = 0.5;
    sheet.thickness = 0.002;
    sheet.friction = 0.5;
    sheet.restitution = 0.0;
    return cloth(place, sheet);
  }
  tremolo_body_id add(tremolo_world* world, CubeKind kind, const tremolo_scene_body& place) {
    tremolo_body_id body = 0;
    const tremolo_status status = add(
        kind, place,
        [&](const auto& p, const auto& m) {
          return tremolo_world_add_reduced(world, &p, model_, &m, box_, &body);
        },
        [&](const auto& p) { return tremolo_world_add_rigid(world, &p, box_, 1.0, &body); },
        [&](const auto& p, const auto& o) { return tremolo_world_add_tets(world, &p, &o, &body); },
        [&](const auto& p, const auto& o) {
          return tremolo_world_add_cloth(world, &p, "implicit-euler", &o, nullptr, 0, &body);
        });
    EXPECT_EQ(status, TREMOLO_OK) << tremolo_last_error();
    return body;
  }
  void add(tremolo_scene* scene, CubeKind kind, const tremolo_scene_body& place) {
    const tremolo_status status = add(
        kind, place,
        [&](const auto& p, const auto& m) {
          return tremolo_scene_add_reduced(scene, &p, model_, &m, box_);
        },
        [&](const auto& p) { return tremolo_scene_add_rigid(scene, &p, box_, 1.0); },
        [&](const auto& p, const auto& o) { return tremolo_scene_add_tets(scene, &p, &o); },
        [&](const auto& p, const auto& o) {
          return tremolo_scene_add_cloth(scene, &p, "implicit-euler", &o, nullptr, 0);
        });
    EXPECT_EQ(status, TREMOLO_OK) << tremolo_last_error();
  }

  static void advance(tremolo_world* world, int steps) {
    ASSERT_EQ(tremolo_world_step(world, steps, nullptr), TREMOLO_OK) << tremolo_last_error();
  }
  static std::vector<double> positions(const tremolo_world* world, tremolo_body_id body) {
    std::vector<double> places(3 * tremolo_world_vertices(world, body));
    EXPECT_EQ(tremolo_world_positions_double(world, body, places.data(), places.size()), TREMOLO_OK)
        << tremolo_last_error();
    return places;
  }
  // The mean over the drawn vertices.
  static Eigen::Vector3d middle(const tremolo_world* world, tremolo_body_id body) {
    const std::vector<double> places = positions(world, body);
    return Eigen::Map<const Eigen::Matrix3Xd>(places.data(), 3,
                                              static_cast<Eigen::Index>(places.size() / 3))
        .rowwise()
        .mean();
  }
  static Eigen::Vector3d momentum(const tremolo_world* world, tremolo_body_id body) {
    Eigen::Vector3d linear;
    EXPECT_EQ(tremolo_world_momentum(world, body, linear.data(), nullptr), TREMOLO_OK);
    return linear;
  }
  // By a fall of one step from rest: momentum is -m g h.
  double mass(CubeKind kind) {
    tremolo_world* world = make_world(false);
    const tremolo_body_id body = add(world, kind, at("one", {0.0, 0.0, 5.0}));
    advance(world, 1);
    return -momentum(world, body).z() / (kFall * kWorldStep);
  }
  static std::vector<std::byte> saved(const tremolo_world* world) {
    std::size_t size = 0;
    EXPECT_EQ(tremolo_world_save(world, nullptr, 0, &size), TREMOLO_OK);
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(tremolo_world_save(world, bytes.data(), size, &size), TREMOLO_OK);
    return bytes;
  }

  static inline std::string folder_;
  tremolo_model* model_ = nullptr;
  tremolo_collider *box_ = nullptr, *plane_ = nullptr;
  tremolo_placed_collider floor_{};
  std::vector<tremolo_world*> worlds_;
};

}  // namespace
}  // namespace tremolo
