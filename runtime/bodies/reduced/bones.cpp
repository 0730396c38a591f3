#include "runtime/bones.h"

#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "runtime/bodies/reduced/bones/bone_weights.h"

namespace tremolo {
namespace {

Status check_model(const Model& model, Eigen::Index bones) {
  if (model.inertia() == nullptr)
    return usage_error(
        "a body on bones needs the inertia integrals, which this basis file has not; make it "
        "again with tremolo-precompute");
  if (bones > 1 && model.elements().corners.empty())
    return usage_error(
        "a body on several bones needs its tetrahedra, which this basis file has not kept; make "
        "it again with tremolo-precompute --keep-elements");
  return Success{};
}

// Errors: kUsage for a model without inertia integrals or, with more than one bone, without its
// tetrahedra; those of reading the interior and of share_inertia.
Result<std::shared_ptr<const Skin>> with_shares(const Model& model, const VertexBlock& interior,
                                                Skin skin) {
  if (skin.drawn.cols() == 1) {
    skin.shares = {model.inertia_about_origin()};
    return std::make_shared<const Skin>(std::move(skin));
  }
  const auto shares =
      share_inertia({model.surface(), interior, model.elements(), model.edges(), *model.inertia()},
                    skin.surface, skin.interior);
  if (!shares) return shares.error();
  for (const InertiaIntegrals& share : *shares)
    skin.shares.push_back(std::make_shared<const FrameInertia>(share, Eigen::Vector3d::Zero()));
  return std::make_shared<const Skin>(std::move(skin));
}

}  // namespace

double usual_blend(const Model& model) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : model.surface().rest) box.extend(x);
  return box.isEmpty() ? 1.0 : kUsualBlend * box.diagonal().norm();
}

Result<std::shared_ptr<const Skin>> skin_near_bones(const Model& model,
                                                    std::span<const BoneSegment> bones,
                                                    double blend) {
  if (bones.empty()) return usage_error("a skin needs at least one bone");
  for (std::size_t b = 0; b < bones.size(); ++b)
    if (!bones[b].head.allFinite() || !bones[b].tail.allFinite())
      return usage_error("an end of bone " + std::to_string(b + 1) + " is not finite");
  if (!(blend > 0.0) || !std::isfinite(blend))
    return usage_error("the blend between bones must be positive and finite (m)");
  if (Status s = check_model(model, std::ssize(bones)); !s) return s.error();
  const Result<const VertexBlock*> interior = model.interior();
  if (!interior) return interior.error();
  Skin skin;
  skin.drawn = weights_near(model.drawn().rest, bones, blend);
  skin.surface = weights_near(model.surface().rest, bones, blend);
  skin.interior = weights_near((*interior)->rest, bones, blend);
  return with_shares(model, **interior, std::move(skin));
}

Result<std::shared_ptr<const Skin>> skin_of_weights(const Model& model, BoneWeights drawn) {
  const std::vector<Eigen::Vector3d>& known = model.drawn().rest;
  // A row for each of the author's vertices: their copies have the same.
  if (const auto& render = model.render();
      render != nullptr && !render->surface.sources.empty() &&
      std::cmp_equal(drawn.rows(), render->surface.authored())) {
    BoneWeights all(std::ssize(known), drawn.cols());
    for (Eigen::Index v = 0; v < all.rows(); ++v)
      all.row(v) = drawn.row(render->surface.sources[static_cast<std::size_t>(v)]);
    drawn = std::move(all);
  }
  if (drawn.cols() < 1 || drawn.rows() != std::ssize(known))
    return content_error("there are weights of " + std::to_string(drawn.rows()) +
                         " vertices; the model draws " + std::to_string(known.size()));
  if (const std::string problem = weights_problem(drawn); !problem.empty())
    return content_error(problem);
  if (Status s = check_model(model, drawn.cols()); !s) return s.error();
  const Result<const VertexBlock*> interior = model.interior();
  if (!interior) return interior.error();
  for (Eigen::Index row = 0; row < drawn.rows(); ++row) drawn.row(row) /= drawn.row(row).sum();
  Skin skin;
  skin.surface = weights_of_nearest(model.surface().rest, known, drawn);
  skin.interior = weights_of_nearest((*interior)->rest, known, drawn);
  skin.drawn = std::move(drawn);
  return with_shares(model, **interior, std::move(skin));
}

}  // namespace tremolo
