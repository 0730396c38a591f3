// Bodies of all kinds for tests of their contact.
#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/mixed/mixed_guests.h"
#include "tests/support/meshes/made_cube.h"
#include "tests/support/tet_bodies.h"

namespace tremolo::testing {

struct MixedKind {
  double step = 1e-3;
  double restitution = 1.0, friction = 0.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  TetMethod method = TetMethod::kMidpoint;
  double alpha = 0.0, beta = 0.0;  // of tetrahedra: 1/s, s
};

inline Pose placed_at(const Eigen::Vector3d& position) {
  Pose pose;
  pose.position = position;
  return pose;
}

inline ContactOptions contact_of(const MixedKind& kind, const Eigen::Vector3d& half) {
  ContactOptions contact;
  contact.shape = BoxShape{half};
  contact.friction = kind.friction;
  contact.restitution = kind.restitution;
  return contact;
}

// A reduced cube of 0.1 m and 1 kg, its middle at the mesh's origin.
inline Model::Pointer reduced_cube(const std::string& young) {
  return made_cube("cube-" + young, Eigen::Vector3d::Constant(-0.05), young, "none");
}

inline ContactBody reduced_body(const Model::Pointer& model, const MixedKind& kind,
                                const Eigen::Vector3d& place) {
  Result<ContactBody> body =
      ContactBody::create(model, "ep4", {.step = kind.step}, FrameKind::kFree);
  EXPECT_TRUE(body) << body.error().message;
  EXPECT_TRUE(body->set_contact(contact_of(kind, Eigen::Vector3d::Constant(0.05))));
  EXPECT_TRUE(body->set_pose(placed_at(place)));
  EXPECT_TRUE(body->set_gravity(kind.gravity));
  return std::move(*body);
}

// A cube of 0.1 m and 1 kg in tetrahedra, its middle at the mesh's origin.
inline TetModelPointer tets_cube(double young, int cells) {
  TetMesh mesh = box_mesh({cells, cells, cells}, {0.1, 0.1, 0.1});
  for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(0.05);
  auto model = TetModel::create(mesh, {{{"gel", {young, 0.3, 1000.0}}}, {}}, {});
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

// The surface of that cube, with which points of others collide.
inline TetHullPointer cube_hull(const TetModelPointer& model) {
  const GridNodes nodes{Eigen::Vector3d::Constant(-0.06), 0.005, {25, 25, 25}};
  std::vector<float> values(nodes.size());
  for (std::size_t k = 0, n = 0; k < 25; ++k)
    for (std::size_t j = 0; j < 25; ++j)
      for (std::size_t i = 0; i < 25; ++i, ++n)
        values[n] = static_cast<float>(
            signed_distance(BoxShape{Eigen::Vector3d::Constant(0.05)}, nodes.at(i, j, k)).distance);
  Result<DistanceGrid> grid = DistanceGrid::create(nodes, values);
  EXPECT_TRUE(grid) << grid.error().message;
  return std::make_shared<const TetHull>(model, boundary_points(*model), std::move(*grid));
}

inline TetBody tets_body(const TetModelPointer& model, const MixedKind& kind,
                         const Eigen::Vector3d& place, const Eigen::Vector3d& velocity,
                         const Eigen::Vector3d& spin) {
  TetBodyOptions options;
  options.step = kind.step;
  options.method = kind.method;
  options.gravity = kind.gravity;
  options.alpha = kind.alpha;
  options.beta = kind.beta;
  options.degree.kind = DegreeKind::kQuadratic;
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  Eigen::VectorXd x = model->rest(), v = x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    v.segment<3>(i) = velocity + spin.cross(x.segment<3>(i));
    x.segment<3>(i) += place;
  }
  EXPECT_TRUE(body->set_state(x, v));
  return std::move(*body);
}

// Bodies of all kinds in one group; numbers are of all kinds together.
class MixedWorld {
 public:
  explicit MixedWorld(double step) : step_(step), guests_(step) {}
  MixedWorld(const MixedWorld&) = delete;

  Result<std::size_t> add(std::string name, ContactBody body) {
    (void)name;
    if (body.contact() == nullptr) return usage_error("no contact");
    members_.push_back({true, bodies_.size()});
    bodies_.push_back(std::move(body));
    return members_.size() - 1;
  }
  Result<std::size_t> add(std::string name, TetBody body, const ContactOptions& contact = {},
                          TetHullPointer hull = nullptr) {
    const Result<std::size_t> added =
        guests_.add(std::move(name), std::move(body), contact, std::move(hull));
    if (!added) return added.error();
    members_.push_back({false, *added});
    return members_.size() - 1;
  }
  Result<std::size_t> add(ClothBody body, const ContactOptions& contact = {}) {
    const Result<std::size_t> added = guests_.add(std::move(body), contact);
    if (!added) return added.error();
    members_.push_back({false, *added});
    return members_.size() - 1;
  }
  void set_colliders(std::span<const PlacedCollider> colliders) { colliders_ = colliders; }

  // Error: the names of bodies that failed are not known here.
  Status step() {
    group_.set_guests(&guests_);
    pointers_.clear();
    for (ContactBody& body : bodies_) pointers_.push_back(&body);
    reports_.resize(bodies_.size());
    group_.step(pointers_, colliders_, reports_);
    ++steps_;
    bool made = true;
    for (const StepReport& report : reports_) made = made && report.converged;
    for (std::size_t i = 0; i < guests_.size(); ++i) made = made && !guests_.failed(i);
    return made ? Status(Success{}) : Status(Error{ErrorKind::kSolver, "not solved"});
  }

  std::size_t size() const { return members_.size(); }
  // Null: the body is of the other kind.
  ContactBody* reduced(std::size_t i) {
    return members_[i].first ? &bodies_[members_[i].second] : nullptr;
  }
  TetBody* tets(std::size_t i) {
    if (members_[i].first || guests_.tets(members_[i].second) == nullptr) return nullptr;
    return &guests_.tets(members_[i].second)->body();
  }
  ClothBody* cloth(std::size_t i) {
    if (members_[i].first || guests_.cloth(members_[i].second) == nullptr) return nullptr;
    return &guests_.cloth(members_[i].second)->body();
  }
  ContactAccount account(std::size_t i) const {
    return members_[i].first ? bodies_[members_[i].second].contact_account()
                             : guests_.account(members_[i].second);
  }
  double penetration_max(std::size_t i) const {
    return guests_.penetration_max(members_[i].second);
  }
  double time() const { return steps_ * step_; }
  std::size_t in_islands() const { return guests_.in_islands(); }
  BodyGroup& group() { return group_; }
  MixedGuests& guests() { return guests_; }
  const MixedReport& report() const { return guests_.mixed_report(); }

 private:
  double step_;
  int steps_ = 0;
  MixedGuests guests_;
  std::deque<ContactBody> bodies_;
  std::vector<std::pair<bool, std::size_t>> members_;
  std::span<const PlacedCollider> colliders_;
  BodyGroup group_;
  std::vector<ContactBody*> pointers_;
  std::vector<StepReport> reports_;
};

// Sums over all bodies of a world.
struct MixedSum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double energy = 0.0;  // J, with that of contact
};

inline MixedSum sum_of(MixedWorld& world) {
  MixedSum sum;
  for (std::size_t i = 0; i < world.size(); ++i) {
    sum.energy += world.account(i).energy;
    if (ContactBody* body = world.reduced(i)) {
      sum.linear += body->momentum().linear;
      sum.angular += body->momentum().angular;
      sum.energy += body->energy().total();
    } else if (const ClothBody* cloth = world.cloth(i)) {
      const Momenta momenta = cloth->momenta();
      sum.linear += momenta.linear;
      sum.angular += momenta.angular;
      sum.energy += cloth->kinetic_energy() + cloth->elastic_energy();
    } else {
      TetBody& tets = *world.tets(i);
      sum.linear += tets.momentum();
      sum.angular += tets.angular_momentum();
      sum.energy += tets.kinetic_energy() + tets.elastic_energy() + tets.gravity_energy();
    }
  }
  return sum;
}

}  // namespace tremolo::testing
