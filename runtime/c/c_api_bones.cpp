// tremolo_body_*: bodies on bones, from C.
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/bones.h"
#include "runtime/c/c_api.h"

namespace {

using Eigen::Vector3d;
using tremolo::ContactBody;
using tremolo::Result;
using tremolo::Skin;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::with;

tremolo::Pose bone_pose_from(const double position[3], const double quaternion[4]) {
  return {Vector3d(position),
          Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3])};
}

// make_skin(model): a Result of the skin.
template <class MakeSkin>
tremolo_status create_with_skin(const tremolo_model* model, const tremolo_body_options* options,
                                const double* numbers, tremolo_body** body,
                                const MakeSkin& make_skin) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = tremolo::c_api::need(
            {{model, "the model"}, {numbers, "the bones"}, {body, "the place for the body"}});
        !s)
      return s;
    const Result<tremolo_body_options> full = tremolo::c_api::complete_body_options(options);
    if (!full) return full.error();
    const Result<tremolo::IntegratorOptions> integrator =
        tremolo::c_api::to_integrator_options(*full);
    if (!integrator) return integrator.error();
    Result<std::shared_ptr<const Skin>> skin = make_skin(*model->pointer);
    if (!skin) return skin.error();
    const std::string_view name =
        full->integrator == nullptr ? tremolo::kDefaultIntegrator : full->integrator;
    Result<ContactBody> made =
        ContactBody::create(model->pointer, name, *integrator, std::move(*skin));
    if (!made) return made.error();
    *body = new tremolo_body{std::move(*made)};
    return Success{};
  });
}

// The number of one bone, never kAllBones.
std::size_t one(std::size_t bone) {
  return std::min(bone, tremolo::kAllBones - 1);
}

}  // namespace

tremolo_status tremolo_body_create_on_bones(const tremolo_model* model,
                                            const tremolo_body_options* options, size_t bones,
                                            const double* segments, double blend,
                                            tremolo_body** body) {
  return create_with_skin(model, options, segments, body, [&](const tremolo::Model& known) {
    std::vector<tremolo::BoneSegment> ends;
    for (size_t b = 0; b < bones; ++b)
      ends.push_back({Vector3d(segments + 6 * b), Vector3d(segments + 6 * b + 3)});
    return tremolo::skin_near_bones(known, ends,
                                    blend == 0.0 ? tremolo::usual_blend(known) : blend);
  });
}

tremolo_status tremolo_body_create_with_weights(const tremolo_model* model,
                                                const tremolo_body_options* options, size_t bones,
                                                const double* weights, tremolo_body** body) {
  return create_with_skin(model, options, weights, body, [&](const tremolo::Model& known) {
    return tremolo::skin_of_weights(
        known, Eigen::Map<const tremolo::BoneWeights>(weights, std::ssize(known.drawn().rest),
                                                      static_cast<Eigen::Index>(bones)));
  });
}

tremolo_status tremolo_body_set_bone(tremolo_body* body, size_t bone, const double position[3],
                                     const double quaternion[4]) {
  return with(body, {{position, "the position"}, {quaternion, "the quaternion"}},
              [&](ContactBody& known) {
                return known.set_pose(bone_pose_from(position, quaternion), one(bone));
              });
}

tremolo_status tremolo_body_move_bone_to(tremolo_body* body, size_t bone, const double position[3],
                                         const double quaternion[4],
                                         const tremolo_frame_motion* motion) {
  return with(body, {{position, "the position"}, {quaternion, "the quaternion"}},
              [&](ContactBody& known) {
                std::optional<tremolo::FrameMotion> moves;
                if (motion != nullptr)
                  moves = {Vector3d(motion->acceleration), Vector3d(motion->spin),
                           Vector3d(motion->spin_rate)};
                return known.move_to(bone_pose_from(position, quaternion), moves, one(bone));
              });
}
