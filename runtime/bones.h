// Skins for models: weights of bones, given or by distance (docs/theory.md, "A body on bones").
#pragma once

#include <memory>
#include <span>

#include "common/result.h"
#include "runtime/bodies/reduced/bones/skin.h"
#include "runtime/model.h"

namespace tremolo {

// The default blend between neighbouring bones, as a fraction of the body's size, the diagonal of
// its boundary's box. With twice the value joints bend over twice the length.
inline constexpr double kUsualBlend = 0.1;

// Makes a skin by the distance to bones that are segments
// (runtime/bodies/reduced/bones/bone_weights.h). blend: m. Errors: kUsage without bones, for
// positions that are not finite or a blend that is not positive; those of make_skin.
Result<std::shared_ptr<const Skin>> skin_near_bones(const Model& model,
                                                    std::span<const BoneSegment> bones,
                                                    double blend);

// Makes a skin from weights of the drawn vertices, one row each in the order of model.drawn();
// other vertices have the weights of the nearest drawn vertex. Rows are normalized to sum to one
// exactly. Errors: kContent for invalid weights (weights_problem) or another number of vertices;
// those of make_skin.
Result<std::shared_ptr<const Skin>> skin_of_weights(const Model& model, BoneWeights drawn);

// The default blend of a model, m.
double usual_blend(const Model& model);

}  // namespace tremolo
