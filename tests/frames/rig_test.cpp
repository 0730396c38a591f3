// The bones of a scene's body from the rig of its model: they follow the recorded motion.
#include <memory>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/model.h"
#include "runtime/scene/scene_bones.h"
#include "tests/support/tiny_render.h"

namespace tremolo {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

// Turns about a point.
RigPose turned(double angle, const Vector3d& axis, const Vector3d& about, const Vector3d& way) {
  const Eigen::Quaterniond turn(AngleAxisd(angle, axis.normalized()));
  return {about + way - turn * about, turn};
}

// A hip that walks and turns, a knee that bends on it, an arm of its own; three keys.
std::shared_ptr<const SurfaceRig> walking_rig(std::size_t vertices) {
  SurfaceRig rig;
  rig.bones = {{"hip", kNoParent, {0.1, 0, 0}, {0.1, 0, 1}},
               {"knee", 0, {0.1, 0, 1}, {0.1, 0, 2}},
               {"arm", kNoParent, {1, 0, 0}, {1, 1, 0}}};
  for (std::size_t v = 0; v < vertices; ++v) {
    rig.weights.push_back({static_cast<VertexId>(v), 0, 0.5F});
    rig.weights.push_back({static_cast<VertexId>(v), 1, 0.25F});
    rig.weights.push_back({static_cast<VertexId>(v), 2, 0.25F});
  }
  RigClip walk;
  walk.name = "walk";
  for (int k = 0; k < 3; ++k) {
    walk.times.push_back(0.5 * k);
    const RigPose hip = turned(0.4 * k, {1, 2, 3}, {0.1, 0, 0}, {0.3 * k, 0, 0.1});
    const RigPose bend = turned(-0.7 * k, {0, 1, 0}, {0.1, 0, 1}, {0, 0, 0});
    walk.poses.push_back(hip);
    walk.poses.push_back(
        {hip.rotation * bend.position + hip.position, hip.rotation * bend.rotation});
    walk.poses.push_back(turned(0.2 * k, {0, 0, 1}, {1, 0, 0}, {0, 0, 0}));
  }
  rig.clips = {RigClip{"still", {0.0}, std::vector<RigPose>(3)}, walk};
  return std::make_shared<const SurfaceRig>(std::move(rig));
}

Model::Pointer walking_model() {
  BasisData data = testing::tiny_render_basis();
  data.render->surface.rig = walking_rig(data.render->surface.vertices.size());
  const auto bytes = encode_basis(data, BasisEncoding::kFull);
  EXPECT_TRUE(bytes) << bytes.error().message;
  const auto model = Model::load_from_memory(*bytes);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

TEST(SceneRig, BonesAreAtTheKeysWhereTheClipHasThem) {
  const Model::Pointer model = walking_model();
  SceneBody body;
  body.kind = FrameKind::kDriven;
  body.rig = true;
  body.clip = "walk";
  const Status taken = take_rig(body, *model);
  ASSERT_TRUE(taken) << taken.error().message;
  ASSERT_EQ(body.bones.size(), 3U);
  EXPECT_EQ(body.bones[1].name, "knee");
  EXPECT_EQ(body.bones[1].parent, "hip");
  EXPECT_EQ(body.bone_weights.rows(), std::ssize(model->render()->surface.vertices));
  EXPECT_EQ(body.bone_weights(0, 0), 0.5);
  const Result<BonePaths> paths = BonePaths::create(body);
  ASSERT_TRUE(paths) << paths.error().message;
  const SurfaceRig& rig = *model->render()->surface.rig;
  std::vector<Pose> poses(3);
  for (std::size_t k = 0; k < 3; ++k) {
    paths->poses(rig.clips[1].times[k], poses);
    for (std::size_t b = 0; b < 3; ++b) {
      const RigPose& wanted = rig.clips[1].poses[3 * k + b];
      // Products of some rotations and places of size 1.
      EXPECT_LT((poses[b].position - wanted.position).norm(), 1e-12) << k << " " << b;
      EXPECT_LT(poses[b].rotation.angularDistance(wanted.rotation), 1e-7) << k << " " << b;
    }
  }
}

TEST(SceneRig, TheFirstClipIsTheUsualOneAndAnUnknownOneIsRefused) {
  const Model::Pointer model = walking_model();
  SceneBody body;
  ASSERT_TRUE(take_rig(body, *model));
  for (const SceneBone& bone : body.bones) EXPECT_TRUE(bone.motion.parts.empty()) << "still";
  body.clip = "run";
  const Status none = take_rig(body, *model);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::kContent);
  EXPECT_NE(none.error().message.find("'run'; the render surface has 'still', 'walk'"),
            std::string::npos)
      << none.error().message;
}

}  // namespace
}  // namespace tremolo
