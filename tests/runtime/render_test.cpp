// A model that is drawn as its author's surface.
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/crowd.h"
#include "runtime/tremolo.h"
#include "tests/support/dynamics.h"
#include "tests/support/sample_render.h"
#include "tests/support/temporary_folder.h"

extern "C" int tremolo_c_render_round(const tremolo_model* model);

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Eigen::Index kTubeModes = 6;

BasisData tube_data() {
  return testing::sample_render_basis(
      testing::random_strain_model(testing::spread_omega(kTubeModes, 5.0, 400.0), 0.02, 91));
}

Model::Pointer tube_model(ModelOptions options = {}) {
  const Result<Model::Pointer> model = Model::from_data(tube_data(), options);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

VectorXd some_q() {
  return testing::random_vector(kTubeModes, 0.05, 3);
}

Body body_at(const Model::Pointer& model, const VectorXd& q) {
  Result<Body> body = Body::create(model, "verlet", {});
  EXPECT_TRUE(body->set_state(q, VectorXd::Zero(q.size())));
  return std::move(*body);
}

TEST(Render, WhatIsShownIsTheAuthorsSurface) {
  const Model::Pointer model = tube_model();
  const RenderBlock tube = testing::tube(kTubeModes);
  const VectorXd q = some_q();
  const Body body = body_at(model, q);
  const std::size_t size = 3 * tube.surface.vertices.size();
  std::vector<double> exact(size);
  std::vector<float> rounded(size), with_normals(size), normals(size);
  ASSERT_TRUE(body.surface_positions(exact));
  ASSERT_TRUE(body.surface(rounded));
  ASSERT_TRUE(body.surface(with_normals, normals));
  const VectorXd u = tube.rows * q;
  for (std::size_t i = 0; i < size; ++i) {
    const double expected = tube.surface.vertices[i / 3][i % 3] + u[i];
    EXPECT_NEAR(exact[i], expected, 1e-14);
    EXPECT_NEAR(rounded[i], expected, 2e-6);  // float sums of numbers up to 5
    EXPECT_EQ(rounded[i], with_normals[i]);
  }
  EXPECT_EQ(model->drawn().triangles, tube.surface.triangles);
}

TEST(Render, TheBoundaryIsStillThere) {
  const Model::Pointer model = tube_model();
  const Body body = body_at(model, some_q());
  std::vector<double> boundary(3 * model->surface().rest.size());
  ASSERT_TRUE(body.surface_positions(boundary, SurfaceKind::kBoundary));
  for (std::size_t v = 0; v < model->surface().rest.size(); ++v) {
    const VertexId id = model->surface().vertex_ids[v];
    const Vector3d expected = model->surface().rest[v] + *body.displacement(id);
    EXPECT_LE((Vector3d::Map(boundary.data() + 3 * v) - expected).norm(), 1e-14);
  }
  EXPECT_EQ(body.surface_positions(boundary).error().kind, ErrorKind::kUsage)
      << "a buffer for the boundary is none for the render surface";
}

TEST(Render, TheHullIsShownOnDemand) {
  const Model::Pointer hull = tube_model({.hull = true});
  EXPECT_EQ(hull->render(), nullptr);
  EXPECT_EQ(hull->drawn().rest, hull->surface().rest);
  const std::string path = testing::fresh_folder() + "/tube.tremolo";
  ASSERT_TRUE(write_basis(path, tube_data()));
  const auto loaded = Model::load(path, {.hull = true});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ((*loaded)->render(), nullptr);
  EXPECT_NE((*Model::load(path))->render(), nullptr);
}

TEST(Render, AHullThatIsItsOwnRenderSurfaceIsWhereTheHullIs) {
  BasisData data = tube_data();
  data.render.emplace();
  RenderBlock& render = *data.render;
  render.surface.vertices = data.surface.rest;
  render.surface.triangles = data.triangles;
  render.surface.object_of.assign(data.triangles.size(), 0);
  render.surface.material_of.assign(data.triangles.size(), 0);
  render.surface.objects = render.surface.materials = {"hull"};
  render.rows = data.surface.rows;
  render.anchors = data.surface.vertex_ids;
  const auto with = Model::from_data(data), without = Model::from_data(data, {.hull = true});
  ASSERT_TRUE(with) << with.error().message;
  const Body a = body_at(*with, some_q()), b = body_at(*without, some_q());
  std::vector<float> x(3 * data.surface.rest.size()), y(x), n(x), m(x);
  ASSERT_TRUE(a.surface(x, n));
  ASSERT_TRUE(b.surface(y, m));
  EXPECT_EQ(x, y);
  EXPECT_EQ(n, m);
}

// Vertices that texture coordinates split shade as one; those of a hard edge do not.
TEST(Render, ASeamIsNoCrack) {
  const Body body = body_at(tube_model(), some_q());
  const RenderSurface& surface = body.model().render()->surface;
  std::vector<float> positions(3 * surface.vertices.size()), normals(positions);
  ASSERT_TRUE(body.surface(positions, normals));
  const std::size_t row = testing::kTubeSides + 1;
  for (std::size_t ring = 0; ring < testing::kTubeRings; ++ring)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(normals[3 * ring * row + axis], normals[3 * (ring * row + row - 1) + axis]);
  // The sum over the triangles on both sides of the seam, in double.
  const auto x = [&](VertexId v) {
    return Vector3d(Eigen::Vector3f::Map(positions.data() + 3 * v).cast<double>());
  };
  const auto first = static_cast<VertexId>(2 * row), last = static_cast<VertexId>(3 * row - 1);
  Vector3d sum = Vector3d::Zero();
  for (const Triangle& t : surface.triangles)
    for (const VertexId corner : t)
      if (corner == first || corner == last) sum += (x(t[1]) - x(t[0])).cross(x(t[2]) - x(t[0]));
  const Vector3d normal = Eigen::Vector3f::Map(normals.data() + 3 * first).cast<double>();
  EXPECT_LE((normal - sum.normalized()).norm(), 1e-5);  // floats, and cancellation in the sum
}

TEST(Render, AtRestATubesNormalsAreThoseItCameWith) {
  const Body body = body_at(tube_model(), VectorXd::Zero(kTubeModes));
  const RenderSurface& surface = body.model().render()->surface;
  std::vector<float> positions(3 * surface.vertices.size()), normals(positions);
  ASSERT_TRUE(body.surface(positions, normals));
  for (std::size_t v = testing::kTubeSides + 1;
       v + testing::kTubeSides + 1 < surface.vertices.size(); ++v)
    EXPECT_LE((Eigen::Vector3f::Map(normals.data() + 3 * v) - surface.normals[v]).norm(), 1e-5f);
}

TEST(SmoothPatches, AreThePlacesWithOneNormal) {
  RenderSurface surface;
  surface.vertices.assign(5, {1, 2, 3});
  surface.vertices.emplace_back(0.0, 0, 0);
  surface.vertices.emplace_back(-0.0, 0, 0);
  surface.normals = {{1, 0, 0},    {0, 1, 0}, {1, 0, 0}, {1, 1e-5f, 0},
                     {0, 0.9f, 0}, {0, 0, 1}, {0, 0, 1}};
  const SmoothPatches patches = find_smooth_patches(surface);
  EXPECT_EQ(patches.group_of, (std::vector<std::uint32_t>{0, 1, 0, 0, 2, 3, 3}));
  EXPECT_EQ(patches.count, 4u);
}

TEST(SmoothPatches, WithoutNormalsAreThePlacesOfAnObject) {
  RenderSurface surface;
  surface.vertices.assign(4, {1, 2, 3});
  surface.vertices.emplace_back(0, 0, 0);
  surface.triangles = {{0, 4, 1}, {2, 4, 3}};
  surface.object_of = {0, 1};
  EXPECT_EQ(find_smooth_patches(surface).group_of, (std::vector<std::uint32_t>{0, 0, 1, 1, 2}));
  surface.object_of = {0, 0};
  EXPECT_EQ(find_smooth_patches(surface).count, 2u);
}

TEST(Render, AWorldShowsItToo) {
  const Model::Pointer model = tube_model();
  Result<Crowd> world = Crowd::create(2);
  ASSERT_TRUE(world);
  const Result<GroupId> group = world->add_group(model, {});
  ASSERT_TRUE(group);
  for (unsigned b = 0; b < 6; ++b) {
    ASSERT_TRUE(world->add_body(*group));
    ASSERT_TRUE(world->set_shown(b, true));
    ASSERT_TRUE(world->set_state(b, some_q() * b, VectorXd::Zero(kTubeModes)));
  }
  EXPECT_EQ(world->update_surfaces(), 6u);
  for (unsigned b = 0; b < 6; ++b) {
    const Body body = body_at(model, some_q() * b);
    std::vector<float> expected(3 * model->render()->surface.vertices.size());
    ASSERT_TRUE(body.surface(expected));
    const Result<SurfaceView> view = world->surface(b);
    ASSERT_TRUE(view);
    EXPECT_EQ(std::vector<float>(view->positions.begin(), view->positions.end()), expected);
  }
}

TEST(Render, ACompactFileShowsItFromItsIntegers) {
  const auto bytes = encode_basis(tube_data(), BasisEncoding::kCompact);
  ASSERT_TRUE(bytes);
  const auto model = Model::load_from_memory(*bytes);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_FALSE((*model)->surface_basis().pairs.empty());
  const Body body = body_at(*model, some_q());
  std::vector<float> rounded(3 * (*model)->drawn().rest.size());
  std::vector<double> exact(rounded.size());
  ASSERT_TRUE(body.surface(rounded));
  ASSERT_TRUE(body.surface_positions(exact));
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(rounded[i], exact[i], 2e-6);
}

TEST(Render, FewerModesTakeItsLeadingColumns) {
  const Model::Pointer coarse = tube_model({.modes = 2});
  EXPECT_EQ(coarse->render()->rows, testing::tube(kTubeModes).rows.leftCols(2));
}

TEST(Render, PartsThatDoNotFitAreRefused) {
  for (int member = 0; member < 5; ++member) {
    BasisData data = tube_data();
    if (member == 0) data.render->anchors.pop_back();
    if (member == 1) data.render->surface.triangles[3][1] = 1000;
    if (member == 2) data.render->rows(4, 1) = std::nan("");
    if (member == 3) data.render->surface.vertices[2][0] = std::nan("");
    if (member == 4) data.render->rows.conservativeResize(Eigen::NoChange, 3);
    const auto model = Model::from_data(data);
    ASSERT_FALSE(model) << member;
    EXPECT_EQ(model.error().kind, ErrorKind::kContent);
  }
}

class RenderFromC : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto bytes = encode_basis(tube_data());
    ASSERT_EQ(tremolo_model_load_memory(bytes->data(), bytes->size(), 0, &model_), TREMOLO_OK);
  }
  void TearDown() override { tremolo_model_release(model_); }
  tremolo_model* model_ = nullptr;
};

TEST_F(RenderFromC, TheRoundFromC) {
  EXPECT_EQ(tremolo_c_render_round(model_), 0)
      << "line of c_api_render_test.c; " << tremolo_last_error();
}

TEST_F(RenderFromC, IsWhatTheModelHas) {
  const RenderBlock tube = testing::tube(kTubeModes);
  const std::size_t s = tube.surface.vertices.size(), t = tube.surface.triangles.size();
  std::vector<float> uvs(2 * s);
  std::vector<std::uint8_t> colours(4 * s);
  std::vector<std::uint32_t> materials(t), objects(t), anchors(s);
  ASSERT_EQ(tremolo_model_uvs(model_, uvs.data(), uvs.size()), TREMOLO_OK);
  ASSERT_EQ(tremolo_model_colours(model_, colours.data(), colours.size()), TREMOLO_OK);
  ASSERT_EQ(tremolo_model_triangle_materials(model_, materials.data(), t), TREMOLO_OK);
  ASSERT_EQ(tremolo_model_triangle_objects(model_, objects.data(), t), TREMOLO_OK);
  ASSERT_EQ(tremolo_model_surface_ids(model_, anchors.data(), s), TREMOLO_OK);
  EXPECT_EQ(materials, tube.surface.material_of);
  EXPECT_EQ(objects, tube.surface.object_of);
  for (std::size_t v = 0; v < s; ++v) {
    EXPECT_EQ(uvs[2 * v + 1], tube.surface.uvs[v][1]);
    EXPECT_EQ(colours[4 * v], tube.surface.colours[v][0]);
    EXPECT_EQ(anchors[v], static_cast<std::uint32_t>(tube.anchors[v]));
  }
}

TEST_F(RenderFromC, WrongLengthsAndNullAreWrongUsage) {
  float uv[2] = {};
  std::uint8_t colour[4] = {};
  std::uint32_t index[1] = {};
  EXPECT_EQ(tremolo_model_uvs(model_, uv, 2), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_uvs(nullptr, uv, 2), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_uvs(model_, nullptr, 2), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_colours(model_, colour, 4), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_triangle_materials(model_, index, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_triangle_objects(nullptr, index, 1), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_model_material_name(model_, 2), nullptr);
  EXPECT_EQ(tremolo_model_object_name(nullptr, 0), nullptr);
  EXPECT_EQ(tremolo_model_has_render(nullptr), 0);
}

}  // namespace
}  // namespace tremolo
