#include "runtime/bodies/tets/contact/tet_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/contact/friction.h"

namespace tremolo {
namespace {

struct Depth {
  double depth = 0.0;  // m, positive inside
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

Depth depth_in(const TetObstacle& obstacle, const Eigen::Vector3d& x) {
  const Eigen::Vector3d place = obstacle.pose.rotation.conjugate() * (x - obstacle.pose.position);
  const CollisionDistance found = signed_distance(obstacle.shape, place);
  return {-found.distance, obstacle.pose.rotation * found.normal};
}

// Force and stiffness of a contact on the path t since the start of the step. slip: xi_0 in the
// plane of the normal.
void set_law(double friction, const Eigen::Vector3d& path, const Eigen::Vector3d& slip,
             TetTouch& touch) {
  const Eigen::Vector3d& g = touch.slope;
  const double k = touch.stiffness, length = g.norm();
  const Eigen::Vector3d n = g / length;
  touch.limit = friction * touch.depth * length;
  touch.path = path - n.dot(path) * n;
  touch.trial = slip + touch.path;
  touch.fall = k * g * g.transpose();
  const double size = touch.trial.norm();
  const bool slides = size > touch.limit;
  const double share = slides ? touch.limit / size : 1.0;
  const double held = share * size;
  touch.energy = 0.5 * k * (touch.depth * touch.depth + held * held);
  touch.force = k * (touch.depth * g - share * touch.trial);
  if (touch.limit > 0.0) {
    touch.fall += (share * k) * (Eigen::Matrix3d::Identity() - n * n.transpose());
    if (slides) touch.fall -= (share * k / (size * size)) * touch.trial * touch.trial.transpose();
  }
}

}  // namespace

TetHull::TetHull(TetModelPointer of, std::vector<TetPoint> with,
                 std::optional<DistanceGrid> distances)
    : model(of), points(std::move(with)), grid(std::move(distances)), tree(std::move(of)) {
  for (const TetPoint& point : points)
    stiffness += point.stiffness / static_cast<double>(points.size());
}

std::size_t TetHull::bytes() const {
  return points.capacity() * sizeof(TetPoint) + (grid ? grid->bytes() : 0) + tree.bytes();
}

TetHullPointer boundary_hull(TetModelPointer model) {
  std::vector<TetPoint> points = boundary_points(*model);
  return std::make_shared<const TetHull>(std::move(model), std::move(points), std::nullopt);
}

TetContact::TetContact(TetHullPointer hull, std::vector<TetObstacle> obstacles)
    : hull_(std::move(hull)),
      obstacles_(std::move(obstacles)),
      boxes_(hull_->tree.size()),
      near_(obstacles_.size(), 1),
      fitted_(hull_->model->rest()) {
  touches_.reserve(hull_->points.size());
  for (std::vector<TetFriction>* memory : {&memory_, &kept_memory_, &part_memory_})
    memory->reserve(hull_->points.size());
}

void TetContact::fit(const Eigen::VectorXd& x) {
  if (times_ > 0 && x == fitted_) return;
  fitted_ = x;
  ++times_;
  hull_->tree.fit(x, boxes_);
}

void TetContact::find_obstacles(std::uint32_t p, const Eigen::Vector3d& place) {
  for (std::uint32_t o = 0; o < obstacles_.size(); ++o) {
    if (near_[o] == 0) continue;
    const auto [depth, n] = depth_in(obstacles_[o], place);
    if (!(depth > 0.0)) continue;
    TetTouch& touch = touches_.emplace_back();
    touch.point = p;
    touch.obstacle = o;
    touch.depth = depth;
    touch.slope = n;
    touch.stiffness = hull_->points[p].stiffness;
  }
}

void TetContact::find_partner(std::uint32_t p, const Eigen::Vector3d& place, std::uint32_t number) {
  const TetPartner& partner = partners_[number];
  const TetHull& other = partner.contact->hull();
  const std::optional<TetPlace> found = other.tree.find(*partner.s, partner.contact->boxes_, place);
  if (!found) return;
  const DistanceGrid::Sample sample = other.grid->at(other.tree.rest_place(*found));
  if (!(sample.distance < 0.0)) return;
  const Eigen::Vector3d g = found->gradient.transpose().inverse() * sample.gradient;
  if (!(g.squaredNorm() > 1e-12) || !g.allFinite()) return;
  TetTouch& touch = touches_.emplace_back();
  touch.point = p;
  touch.partner = number;
  touch.nodes = other.model->elements()[found->element].nodes;
  touch.values = found->values;
  touch.depth = -sample.distance;
  touch.slope = g;
  touch.bend = found->gradient;
  const double own = hull_->points[p].stiffness;
  touch.stiffness = own * other.stiffness / (own + other.stiffness);
}

// True if neither the body nor a partner has moved since positions were found; stores their states
// for the next call.
bool TetContact::places_are_known() {
  const std::size_t count = partners_.size() + 1;
  bool known = known_.size() == count;
  known_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const TetContact* contact = i == 0 ? this : partners_[i - 1].contact;
    const Fitted now{contact, contact->times_};
    known = known && known_[i] == now;
    known_[i] = now;
  }
  return known;
}

void TetContact::find_places(const Eigen::VectorXd& s) {
  touches_.clear();
  const Eigen::Vector3d middle = box().center();
  const double reach = 0.5 * box().diagonal().norm();
  for (std::size_t o = 0; o < obstacles_.size(); ++o)
    near_[o] = depth_in(obstacles_[o], middle).depth > -reach ? 1 : 0;
  for (std::uint32_t p = 0; p < hull_->points.size(); ++p) {
    const Eigen::Vector3d place = at_point(hull_->points[p], s);
    find_obstacles(p, place);
    for (std::uint32_t other = 0; other < partners_.size(); ++other)
      if (partners_[other].contact->box().contains(place)) find_partner(p, place, other);
  }
}

std::uint32_t TetContact::number_of(const TetTouch& touch) const {
  return touch.partner == kNoPartner ? touch.obstacle : partners_[touch.partner].body;
}

const TetFriction* TetContact::remembered(const TetTouch& touch) const {
  const bool on_body = touch.partner != kNoPartner;
  const std::uint32_t number = number_of(touch);
  auto one = std::lower_bound(
      memory_.begin(), memory_.end(), touch.point,
      [](const TetFriction& memory, std::uint32_t point) { return memory.point < point; });
  for (; one != memory_.end() && one->point == touch.point; ++one)
    if (one->on_body == on_body && one->obstacle == number) return &*one;
  return nullptr;
}

void TetContact::find(const Eigen::VectorXd& s, const Eigen::VectorXd& from) {
  if (!places_are_known()) find_places(s);
  for (TetTouch& touch : touches_) {
    const TetPoint& point = hull_->points[touch.point];
    Eigen::Vector3d path = at_point(point, s) - at_point(point, from);
    double friction = 0.0;
    if (touch.partner == kNoPartner) {
      friction = obstacles_[touch.obstacle].friction;
    } else {
      const TetPartner& partner = partners_[touch.partner];
      friction = partner.friction;
      for (std::size_t i = 0; i < kMostNodes; ++i) {
        const Eigen::Index k = 3 * Eigen::Index{touch.nodes[i]};
        path -= touch.values[i] * (partner.s->segment<3>(k) - partner.from->segment<3>(k));
      }
    }
    Eigen::Vector3d slip = Eigen::Vector3d::Zero();
    if (const TetFriction* memory = remembered(touch); memory != nullptr) {
      Eigen::Vector3d normal = memory->normal;
      slip = memory->slip;
      if (touch.partner != kNoPartner) {
        const Eigen::Matrix3d turn = nearest_rotation(touch.bend);
        normal = turn * normal;
        slip = turn * slip;
      }
      slip = turn_to_plane(slip, normal, touch.slope.normalized());
    }
    set_law(friction, path, slip, touch);
  }
}

void TetContact::forget_body(std::uint32_t body) {
  std::erase_if(memory_, [body](const TetFriction& memory) {
    return memory.on_body && memory.obstacle == body;
  });
}

// Points that leave forget their displacement.
void TetContact::end_step(double whole) {
  memory_.clear();
  for (const TetTouch& touch : touches_) {
    if (!(touch.limit > 0.0)) continue;
    Eigen::Vector3d slip = touch.trial + (whole - 1.0) * touch.path;
    const double size = slip.norm();
    if (size > touch.limit) slip *= touch.limit / size;
    Eigen::Vector3d normal = touch.slope.normalized();
    if (touch.partner != kNoPartner) {
      const Eigen::Matrix3d back = nearest_rotation(touch.bend).transpose();
      slip = back * slip;
      normal = back * normal;
    }
    memory_.push_back({touch.point, touch.partner != kNoPartner, number_of(touch), slip, normal});
  }
}

void TetContact::add_forces(Eigen::VectorXd& f) const {
  for (const TetTouch& touch : touches_) {
    const TetPoint& point = hull_->points[touch.point];
    for (std::uint32_t i = 0; i < point.count; ++i)
      f.segment<3>(3 * Eigen::Index{point.nodes[i]}) += point.shares[i] * touch.force;
  }
}

void TetContact::add_partner_forces(std::uint32_t partner, Eigen::VectorXd& f) const {
  for (const TetTouch& touch : touches_) {
    if (touch.partner != partner) continue;
    for (std::size_t i = 0; i < kMostNodes; ++i)
      f.segment<3>(3 * Eigen::Index{touch.nodes[i]}) -= touch.values[i] * touch.force;
  }
}

TetContact::Look TetContact::look() const {
  Look seen;
  for (const TetTouch& touch : touches_) {
    seen.energy += touch.energy;
    seen.depth = std::max(seen.depth, touch.depth);
    ++seen.touching;
  }
  return seen;
}

TetContact::Look TetContact::look(const Eigen::VectorXd& x) const {
  Look seen;
  for (const TetPoint& point : hull_->points)
    for (const TetObstacle& obstacle : obstacles_) {
      const double depth = depth_in(obstacle, at_point(point, x)).depth;
      if (!(depth > 0.0)) continue;
      seen.energy += 0.5 * point.stiffness * depth * depth;
      seen.depth = std::max(seen.depth, depth);
      ++seen.touching;
    }
  return seen;
}

std::size_t TetContact::bytes() const {
  return touches_.capacity() * sizeof(TetTouch) + 3 * memory_.capacity() * sizeof(TetFriction) +
         static_cast<std::size_t>(fitted_.size()) * sizeof(double) +
         boxes_.size() * sizeof(TetTree::Box) + partners_.capacity() * sizeof(TetPartner);
}

}  // namespace tremolo
