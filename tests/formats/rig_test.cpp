// Skeletons of surface files: bones, weights, recorded motions, and their way through files.
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/surface/flat_rig.h"
#include "formats/surface/surface_answer.h"
#include "formats/surface/surface_reader.h"
#include "tests/support/meshes/rigged_files.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"
#include "tests/support/tiny_render.h"

namespace tremolo {
namespace {

using namespace tremolo::testing;
using Eigen::Vector3d;

SurfaceFile read_rigged(const std::string& name, const std::string& bytes,
                        const SurfaceReadOptions& options = {}) {
  const TemporaryFolder folder;
  Result<SurfaceFile> file = read_surface(folder.write(name, bytes), options);
  EXPECT_TRUE(file) << file.error().message;
  return file ? std::move(*file) : SurfaceFile{};
}

Vector3d moved(const RigPose& pose, const Vector3d& x) {
  return pose.rotation * x + pose.position;
}

// scale: of lengths, in what the box is in metres.
void expect_bent_box(const RenderSurface& surface, double scale) {
  ASSERT_NE(surface.rig, nullptr);
  const SurfaceRig& rig = *surface.rig;
  ASSERT_EQ(rig.bones.size(), 2U);
  EXPECT_EQ(rig.bones[0].name, "hip.L");
  EXPECT_EQ(rig.bones[1].name, "knee joint");
  EXPECT_EQ(rig.bones[0].parent, kNoParent);
  EXPECT_EQ(rig.bones[1].parent, 0);
  EXPECT_LT(rig.bones[0].head.norm(), 1e-6 * scale);
  EXPECT_LT((rig.bones[1].head - Vector3d(0, 0, 1.5 * scale)).norm(), 1e-6 * scale);
  EXPECT_LT((rig.bones[0].tail - rig.bones[1].head).norm(), 1e-12);
  ASSERT_EQ(rig.weights.size(), surface.vertices.size());
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    EXPECT_EQ(rig.weights[v].vertex, static_cast<VertexId>(v));
    EXPECT_EQ(rig.weights[v].bone, surface.vertices[v].z() > scale ? 1U : 0U);
    EXPECT_NEAR(rig.weights[v].weight, 1.0F, 1e-6F);
  }
  ASSERT_EQ(rig.clips.size(), 1U);
  const RigClip& clip = rig.clips[0];
  EXPECT_NE(clip.name.find("bend"), std::string::npos) << clip.name;
  ASSERT_EQ(clip.times.size(), 2U);
  EXPECT_NEAR(clip.times[1] - clip.times[0], 1.0, 1e-6);
  ASSERT_EQ(clip.poses.size(), 4U);
  const Vector3d top(1 * scale, 2 * scale, 3 * scale);
  EXPECT_LT((moved(clip.poses[1], top) - top).norm(), 1e-6 * scale) << "begins at rest";
  // About x through (0, 0, 1.5): y to z, z to -y. The files have floats.
  const Vector3d there(1 * scale, -1.5 * scale, 3.5 * scale);
  EXPECT_LT((moved(clip.poses[3], top) - there).norm(), 1e-5 * scale)
      << moved(clip.poses[3], top).transpose();
  EXPECT_LT((moved(clip.poses[2], top) - top).norm(), 1e-6 * scale) << "the hip stays";
}

TEST(Rig, OfAGltfHasBonesWeightsAndMotionWithTheirNames) {
  expect_bent_box(read_rigged("box.gltf", rigged_gltf()).surface, 1);
  expect_bent_box(read_rigged("box.gltf", rigged_gltf(true)).surface, 1);
  expect_bent_box(read_rigged("box.gltf", rigged_gltf(), {.metres_per_unit = 0.01}).surface, 0.01);
}

TEST(Rig, OfAnFbxHasBonesWeightsAndMotionWithTheirNames) {
  expect_bent_box(read_rigged("box.fbx", rigged_fbx()).surface, 1);
}

TEST(Rig, OfASurfaceWithoutASkinIsNone) {
  EXPECT_EQ(read_rigged("box.gltf", box_gltf(data_uri(box_gltf_buffer()))).surface.rig, nullptr);
  EXPECT_EQ(read_rigged("box.obj", box_obj()).surface.rig, nullptr);
}

void expect_same_rig(const SurfaceRig& a, const SurfaceRig& b) {
  const FlatRig x = flatten(a), y = flatten(b);
  EXPECT_EQ(x.names, y.names);
  EXPECT_EQ(x.parents, y.parents);
  EXPECT_EQ(x.ends, y.ends);
  EXPECT_EQ(x.places, y.places);
  EXPECT_EQ(x.weights, y.weights);
  EXPECT_EQ(x.clip_names, y.clip_names);
  EXPECT_EQ(x.clip_frames, y.clip_frames);
  EXPECT_EQ(x.clip_times, y.clip_times);
  EXPECT_EQ(x.clip_poses, y.clip_poses);
}

TEST(Rig, ComesThroughABasisFileAsItIs) {
  BasisData data = tiny_basis();
  data.render = tiny_render();
  auto rig = std::make_shared<SurfaceRig>();
  rig->bones = {{"a", kNoParent, {0, 0, 0}, {0, 0, 1}}, {"b c", 0, {0, 0, 1}, {0, 0, 2}}};
  for (std::size_t v = 0; v < data.render->surface.vertices.size(); ++v) {
    rig->weights.push_back({static_cast<VertexId>(v), 0, 0.25F});
    rig->weights.push_back({static_cast<VertexId>(v), 1, 0.75F});
  }
  RigClip clip{"walk", {0.5, 1.0, 2.0}, std::vector<RigPose>(6)};
  clip.poses[3].position = {1, 2, 3};
  clip.poses[5].rotation = Eigen::Quaterniond(0.6, 0, 0.8, 0);
  rig->clips = {clip};
  data.render->surface.rig = rig;
  const auto bytes = encode_basis(data, BasisEncoding::kFull);
  ASSERT_TRUE(bytes) << bytes.error().message;
  Result<BasisReader> reader = BasisReader::from_memory(*bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  const auto render = read_render(*reader);
  ASSERT_TRUE(render) << render.error().message;
  ASSERT_TRUE((*render)->surface.rig);
  expect_same_rig(*(*render)->surface.rig, *rig);
}

TEST(Rig, WhoseArraysDoNotFitIsNone) {
  const RenderSurface surface = read_rigged("box.gltf", rigged_gltf()).surface;
  ASSERT_NE(surface.rig, nullptr);
  const std::size_t vertices = surface.vertices.size();
  const FlatRig good = flatten(*surface.rig);
  EXPECT_NE(unflatten(good, vertices), nullptr);
  EXPECT_EQ(unflatten(good, vertices + 1), nullptr) << "a vertex without weights";
  const auto none = [&](auto&& spoil) {
    FlatRig bad = good;
    spoil(bad);
    return unflatten(bad, vertices) == nullptr;
  };
  EXPECT_TRUE(none([](FlatRig& r) { r.names.pop_back(); }));
  EXPECT_TRUE(none([](FlatRig& r) { r.names = std::string("a\0a\0", 4); }));
  EXPECT_TRUE(none([](FlatRig& r) { r.parents[0] = 1; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.parents[1] = 1; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.ends.pop_back(); }));
  EXPECT_TRUE(none([](FlatRig& r) { r.places[1] = 2; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.places[0] = 0xffffffff; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.weights[0] = 0.5F; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.weights[0] = std::nanf(""); }));
  EXPECT_TRUE(none([](FlatRig& r) { r.clip_frames[0] = 3; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.clip_frames[0] = 0xffffffff; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.clip_times[1] = r.clip_times[0]; }));
  EXPECT_TRUE(none([](FlatRig& r) { r.clip_poses[3] = 2; }));
}

}  // namespace
}  // namespace tremolo
