// Rays on bodies on several bones: agreement with a driven frame, and with all triangles of the
// skinned surface.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/frames/frame_models.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::bar_bones;
using testing::make_framed;
using testing::make_rigged;

// A tube around the bar, closed at its ends, with the displacements of the bar's nearest vertices.
RenderBlock tube_of(const testing::RiggedBar& bar, int rings, int around) {
  RenderBlock tube;
  RenderSurface& surface = tube.surface;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double angle = 2.0 * std::numbers::pi * j / around;
      const double radius = i == 0 || i == rings ? 0.0 : 0.07;
      surface.vertices.emplace_back(0.6 * i / rings, 0.05 + radius * std::cos(angle),
                                    0.06 + radius * std::sin(angle));
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < around; ++j) {
      const VertexId a = i * around + j, b = i * around + (j + 1) % around;
      // At the ends a ring is one point.
      if (i > 0) surface.triangles.push_back({a, a + around, b});
      if (i < rings - 1) surface.triangles.push_back({b, a + around, b + around});
    }
  surface.objects = surface.materials = {"tube"};
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.material_of = surface.object_of;
  const VertexBlock& known = bar.data.surface;
  tube.rows.resize(3 * std::ssize(surface.vertices), known.rows.cols());
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < known.rest.size(); ++k)
      if ((known.rest[k] - surface.vertices[v]).norm() <
          (known.rest[nearest] - surface.vertices[v]).norm())
        nearest = k;
    tube.anchors.push_back(known.vertex_ids[nearest]);
    tube.rows.middleRows<3>(3 * v) = known.rows.middleRows<3>(3 * nearest);
  }
  return tube;
}

// The bar drawn as the tube; its boundary is a soup of triangles.
Model::Pointer tube_model(Eigen::Index modes, int rings, int around) {
  const testing::RiggedBar bar = testing::rigged_bar(modes);
  BasisData data = bar.data;
  data.render = tube_of(bar, rings, around);
  data.triangles.clear();
  const auto count = static_cast<VertexId>(data.surface.rest.size());
  for (VertexId v = 0; v < count; ++v)
    data.triangles.push_back({v, (v + 7) % count, (v + 18) % count});
  const Result<Model::Pointer> model = Model::from_data(data);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

ContactBody tube_on_bones(const Model::Pointer& model) {
  return make_rigged(model, *skin_near_bones(*model, bar_bones(), 0.08), {.step = 3e-3});
}

// Turned at the elbow and once more, about another axis, at the wrist.
void bend(ContactBody& body) {
  const Vector3d joints[] = {{0.0, 0.05, 0.06}, {0.2, 0.05, 0.06}, {0.4, 0.05, 0.06}};
  const Vector3d turns[] = {{0.3, -0.2, 0.5}, {0.0, -0.9, 0.2}, {0.3, -0.6, 0.9}};
  Pose chain{{0.4, -1.0, 2.0}, Eigen::Quaterniond::Identity()};
  for (std::size_t b = 0; b < 3; ++b) {
    const Vector3d joint = chain * joints[b];
    chain.rotation = chain.rotation * turn_by(turns[b]);
    chain.position = joint - chain.rotation * joints[b];
    ASSERT_TRUE(body.set_pose(chain, b));
  }
}

std::vector<Vector3d> places_of(const ContactBody& body, SurfaceKind surface) {
  const std::size_t count =
      (surface == SurfaceKind::kDrawn ? body.model().drawn().rest : body.model().surface().rest)
          .size();
  std::vector<double> numbers(3 * count);
  EXPECT_TRUE(body.surface_positions(std::span<double>(numbers), surface));
  std::vector<Vector3d> places;
  for (std::size_t v = 0; v < count; ++v) places.push_back(Vector3d::Map(&numbers[3 * v]));
  return places;
}

struct Ray {
  Vector3d origin, direction;
};

// Rays from around the places: most of them towards one of the places or near it, some anywhere.
std::vector<Ray> rays_at(const std::vector<Vector3d>& places, int count, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto random = [&] {
    return Vector3d(normal(generator), normal(generator), normal(generator));
  };
  std::vector<Ray> rays;
  for (int k = 0; k < count; ++k) {
    const Vector3d aim = places[generator() % places.size()] + 0.03 * random();
    const Vector3d origin = aim + 0.7 * random();
    rays.push_back({origin, k % 4 == 0 ? Vector3d(random()) : Vector3d(3.0 * (aim - origin))});
  }
  return rays;
}

// Distance in units of the direction's length, by a linear system.
std::optional<double> met(const Ray& ray, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Eigen::Matrix3d columns;
  columns << ray.direction, a - b, a - c;
  const Vector3d x = columns.fullPivLu().solve(Vector3d(a - ray.origin));
  if (x[0] >= 0.0 && x[1] >= 0.0 && x[2] >= 0.0 && x[1] + x[2] <= 1.0) return x[0];
  return std::nullopt;
}

TEST(BonesPick, OnBonesThatMoveTogetherItIsThatOfADrivenFrame) {
  const Model::Pointer model = tube_model(5, 24, 12);
  ContactBody boned = tube_on_bones(model);
  ContactBody driven = make_framed(model, FrameKind::kDriven, {.step = 3e-3});
  for (ContactBody* body : {&boned, &driven}) {
    ASSERT_TRUE(body->set_pose({{0.4, -1.0, 2.0}, turn_by({0.7, -0.4, 1.1})}));
    ASSERT_TRUE(
        body->set_state(testing::random_vector(5, 0.1, 1), testing::random_vector(5, 0.1, 2)));
  }
  for (const SurfaceKind surface : {SurfaceKind::kDrawn, SurfaceKind::kBoundary}) {
    int hits = 0, misses = 0;
    for (const Ray& ray : rays_at(places_of(driven, surface), 500, 7)) {
      const auto one = driven.pick(ray.origin, ray.direction, surface);
      const auto other = boned.pick(ray.origin, ray.direction, surface);
      ASSERT_TRUE(one && other);
      ASSERT_EQ(one->has_value(), other->has_value());
      ++(*one ? hits : misses);
      if (!*one) continue;
      EXPECT_EQ((*one)->place.triangle, (*other)->place.triangle);
      EXPECT_EQ((*one)->vertex, (*other)->vertex);
      EXPECT_LE(((*one)->place.weights - (*other)->place.weights).norm(), 1e-9);
      EXPECT_NEAR((*one)->distance, (*other)->distance, 1e-12);
      EXPECT_LE(((*one)->point - (*other)->point).norm(), 1e-12);
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(misses, 100);
  }
}

TEST(BonesPick, OnABentArmItIsTheFirstOfAllTriangles) {
  ContactBody body = tube_on_bones(tube_model(5, 24, 12));
  bend(body);
  ASSERT_TRUE(body.set_state(testing::random_vector(5, 0.1, 1), testing::random_vector(5, 0.1, 2)));
  for (const SurfaceKind surface : {SurfaceKind::kDrawn, SurfaceKind::kBoundary}) {
    const std::vector<Triangle>& triangles =
        surface == SurfaceKind::kDrawn ? body.model().drawn().triangles : body.model().triangles();
    const std::vector<Vector3d> places = places_of(body, surface);
    int hits = 0, misses = 0;
    for (const Ray& ray : rays_at(places, 300, 5)) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [a, b, c] : triangles)
        if (const auto far = met(ray, places[a], places[b], places[c]))
          nearest = std::min(nearest, *far);
      const auto hit = body.pick(ray.origin, ray.direction, surface);
      ASSERT_TRUE(hit) << hit.error().message;
      ASSERT_EQ(hit->has_value(), std::isfinite(nearest));
      ++(*hit ? hits : misses);
      if (!*hit) continue;
      EXPECT_NEAR((*hit)->distance, nearest * ray.direction.norm(), 1e-10);
      const Vector3d& weights = (*hit)->place.weights;
      EXPECT_GE(weights.minCoeff(), 0.0);
      EXPECT_NEAR(weights.sum(), 1.0, 1e-14);
      Vector3d point = Vector3d::Zero();
      for (std::size_t k = 0; k < 3; ++k)
        point += weights[k] * places[triangles[(*hit)->place.triangle][k]];
      EXPECT_LE(((*hit)->point - point).norm(), 1e-11);
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(misses, 50);
  }
}

TEST(BonesPick, AHandTakesTheVertexOfTheHit) {
  ContactBody body = tube_on_bones(tube_model(5, 24, 12));
  bend(body);
  ASSERT_TRUE(body.set_contact({.points = 20, .colliders = false}));
  const Triangle& corners = body.model().drawn().triangles[400];
  const std::vector<Vector3d> places = places_of(body, SurfaceKind::kDrawn);
  const Vector3d aim =
      0.2 * places[corners[0]] + 0.5 * places[corners[1]] + 0.3 * places[corners[2]];
  const Vector3d out = (places[corners[1]] - places[corners[0]])
                           .cross(places[corners[2]] - places[corners[0]])
                           .normalized();
  const auto hit = body.pick(aim + 0.01 * out, -out);
  ASSERT_TRUE(hit && *hit);
  EXPECT_LE(((*hit)->point - aim).norm(), 1e-12);
  EXPECT_EQ((*hit)->vertex, body.model().drawn().mesh_vertices[corners[1]]);
  EXPECT_FALSE(body.grab((*hit)->place, 500.0, 1.0));
  const Result<std::size_t> hand = body.grab((*hit)->vertex, 500.0, 1.0);
  ASSERT_TRUE(hand) << hand.error().message;
  ASSERT_TRUE(body.move_hand(*hand, *body.position((*hit)->vertex) + 0.01 * out));
  ASSERT_TRUE(body.step().converged);
  EXPECT_GT(body.hand_force(*hand).dot(out), 0.0);
}

TEST(BonesPick, RaysThatAreNoneAreRefused) {
  const ContactBody body = tube_on_bones(tube_model(5, 4, 5));
  EXPECT_EQ(body.pick({NAN, 0, 0}, {0, 0, 1}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(body.pick({0, 0, 0}, {0, 0, 0}).error().kind, ErrorKind::kUsage);
}

// Prints the time of a ray (docs/performance.md).
TEST(BonesPick, TenThousandTrianglesAreTestedInTime) {
  ContactBody body = tube_on_bones(tube_model(30, 101, 50));
  bend(body);
  ASSERT_EQ(body.model().drawn().triangles.size(), 10'000U);
  const std::vector<Ray> rays = rays_at(places_of(body, SurfaceKind::kDrawn), 200, 3);
  double quickest = std::numeric_limits<double>::infinity();
  for (int turn = 0; turn < 5; ++turn) {
    const auto start = std::chrono::steady_clock::now();
    for (const Ray& ray : rays) ASSERT_TRUE(body.pick(ray.origin, ray.direction));
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
    quickest = std::min(quickest, took.count() / static_cast<double>(rays.size()));
  }
  std::printf("a ray on 10000 triangles on three bones, r = 30: %.0f us\n", quickest);
}

}  // namespace
}  // namespace tremolo
