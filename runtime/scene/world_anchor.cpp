#include "runtime/scene/world_anchor.h"

#include "formats/basis/basis_data.h"
#include "runtime/model.h"

namespace tremolo {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A tetrahedron with one shape, in which no vertex moves.
Result<ContactBody> make_world_anchor(double step) {
  BasisData data;
  data.lambda = Eigen::VectorXd::Constant(1, 1.0);
  data.vertex_count = 4;
  data.total_mass = 1.0;
  data.surface.vertex_ids = {0, 1, 2, 3};
  data.surface.rest = {Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  data.surface.rows.setZero(12, 1);
  data.interior.rows.resize(0, 1);
  data.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  InertiaIntegrals inertia;
  inertia.mass = 1.0;
  inertia.first_moment = Vector3d::Constant(0.25);
  inertia.second_moment = Matrix3d::Constant(0.05) + 0.05 * Matrix3d::Identity();
  inertia.linear.setZero(12, 1);
  inertia.B.setZero(9, 1);
  data.inertia = std::move(inertia);
  const Result<Model::Pointer> model = Model::from_data(data);
  if (!model) return model.error();
  Result<ContactBody> body = ContactBody::create(*model, "ep4", {.step = step}, FrameKind::kFixed);
  if (!body) return body.error();
  ContactOptions contact;
  contact.colliders = false;
  if (Status s = body->set_contact(contact); !s) return s.error();
  return body;
}

JointPlace world_place(const Vector3d& position, const ContactBody& anchor) {
  JointPlace place;
  place.rest = position;
  place.rows.setZero(3, anchor.model().modes());
  return place;
}

}  // namespace tremolo
