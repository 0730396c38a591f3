// Skins for models: who carries what, by hand or by distance (docs/theory.md, "A body on bones").
#pragma once

#include <memory>
#include <span>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/skeleton/skin.h"

namespace tremolo {

// The blend between neighbouring bones where nobody says one, in parts of the body's size, the
// diagonal of its boundary's box. Twice as much bends joints over twice the length.
inline constexpr double kUsualBlend = 0.1;

// By the distance to bones that are segments (runtime/skeleton/bone_weights.h). blend: m.
// Errors: kUsage without bones, for places that are not finite or a blend that is not positive;
// those of make_skin.
Result<std::shared_ptr<const Skin>> skin_near_bones(const Model& model,
                                                    std::span<const BoneSegment> bones,
                                                    double blend);

// From weights of the drawn vertices, a row for each in the order of model.drawn(); those of other
// vertices are the nearest drawn vertex's. Rows are made to sum to one exactly. Errors: kContent
// for weights that are none (weights_problem) or of another number of vertices; those of make_skin.
Result<std::shared_ptr<const Skin>> skin_of_weights(const Model& model, BoneWeights drawn);

// The usual blend of a model, m.
double usual_blend(const Model& model);

}  // namespace tremolo
