#include "runtime/scene/welds.h"

#include <algorithm>

#include "common/text.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/springs.h"
#include "runtime/contact/weld.h"

namespace tremolo {

using Eigen::Vector3d;

Result<WeldVertices> WeldVertices::create(const ContactBody& body,
                                          std::span<const VertexId> vertices) {
  if (Status s = check_joinable(body); !s) return s.error();
  WeldVertices made;
  made.body_ = &body;
  for (const VertexId vertex : vertices)
    if (Status s = take(made.rows_.emplace_back(), vertex_place(body, vertex)); !s)
      return s.error();
  const VertexBlock& boundary = body.model().surface();
  for (std::size_t i = 0; vertices.empty() && i < boundary.rest.size(); ++i)
    if (Status s = take(made.rows_.emplace_back(), vertex_place(body, boundary.vertex_ids[i])); !s)
      return s.error();
  for (const JointPlace& row : made.rows_) made.positions_.push_back(place_now(body, row));
  return made;
}

JointPlace WeldVertices::at(const Vector3d& position, double& offset) const {
  const WeldPlace place = weld_place(positions_, position);
  offset = place.offset.norm();
  JointPlace point;
  point.rest = body_->pose().rotation.conjugate() * place.offset;
  point.rows.setZero(3, body_->model().modes());
  for (const WeldPlace::Point& one : place.used()) {
    point.rest += one.weight * rows_[one.number].rest;
    point.rows += one.weight * rows_[one.number].rows;
  }
  if (body_->bones() < 2) return point;
  point.bones.resize(body_->bones(), 0.0);
  for (const WeldPlace::Point& one : place.used())
    for (std::size_t b = 0; b < point.bones.size(); ++b)
      point.bones[b] += one.weight * rows_[one.number].bones[b];
  // Between vertices on other bones the mean of their maps is elsewhere.
  bring_to(*body_, position, point);
  return point;
}

void set_weld_spring(Joint& joint, const JointOptions& options, std::size_t count, double lightness,
                     double h) {
  const HandSpring most = stiffest_spring(1.0 / lightness, h);
  joint.stiffness = most.stiffness;
  joint.damping = most.damping;
  joint.touch = options.touch;
  if (!options.stiffness) return;
  joint.stiffness = *options.stiffness / static_cast<double>(count);
  joint.damping = options.damping / static_cast<double>(count);
  limit_spring(most, h, joint.stiffness, joint.damping);
}

Error too_far_to_weld(double apart, double gap) {
  return usage_error("a vertex is " + number_text(apart) +
                     " m from the surface that it is welded to, more than `gap` of " +
                     number_text(gap) +
                     " m: put a body elsewhere, select other vertices, or say a larger `gap`");
}

Result<std::vector<Joint>> make_weld(const ContactBody& first, std::span<const VertexId> at,
                                     const ContactBody& second, std::span<const VertexId> to,
                                     const JointOptions& options, double gap) {
  if (first.options().step != second.options().step)
    return usage_error("bodies that are joined have one step size");
  const Result<WeldVertices> from = WeldVertices::create(first, at);
  if (!from) return from.error();
  const Result<WeldVertices> onto = WeldVertices::create(second, to);
  if (!onto) return onto.error();
  std::vector<Joint> joints;
  std::vector<double> lightness;  // of each joint alone, 1/kg
  double farthest = 0.0;
  for (std::size_t k = 0; k < from->rows().size(); ++k) {
    Joint joint;
    double offset = 0.0;
    joint.first = from->rows()[k];
    joint.second = onto->at(from->positions()[k], offset);
    farthest = std::max(farthest, offset);
    const double light = 1.0 / first.mass_at(joint.first) + 1.0 / second.mass_at(joint.second);
    if (!(light > 0.0)) continue;
    lightness.push_back(light);
    joints.push_back(std::move(joint));
  }
  if (farthest > gap) return too_far_to_weld(farthest, gap);
  if (joints.empty()) return usage_error("neither place moves: there is nothing to join");
  const std::size_t count = joints.size();
  for (std::size_t k = 0; k < count; ++k)
    set_weld_spring(joints[k], options, count, static_cast<double>(count) * lightness[k],
                    first.options().step);
  return joints;
}

}  // namespace tremolo
