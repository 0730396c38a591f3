#include "runtime/contact/solve/contact_island.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostIterations = 80;
constexpr int kHalvings = 12;

// The law of a point of `first` and the shape of `second`: stiffness in proportion to the reduced
// mass; friction and restitution are geometric means.
ContactLaw law_between(const ContactStep& first, const ContactStep& second) {
  ContactLaw law = first.law();
  if (second.can_move()) law.stiffness *= second.mass() / (first.mass() + second.mass());
  law.friction = std::sqrt(first.law().friction * second.law().friction);
  law.restitution = std::sqrt(first.law().restitution * second.law().restitution);
  return law;
}

// What a field on the points of a body is at a place near its surface: their mean by weights
// 1/(l^2 + e^2)^2, smooth everywhere. This is e^2.
double smallest_distance2(const ContactPoints& points) {
  return 0.25 * points.gap * points.gap + 1e-6 * points.extent * points.extent;
}

// The transposed rows of U there.
void nearby_rows(const ContactPoints& points, const Vector3d& place, Eigen::MatrixX3d& rows) {
  const double least = smallest_distance2(points);
  rows.resize(points.rows.rows(), 3);
  rows.setZero();
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double near = 1.0 / ((place - points.rest[i]).squaredNorm() + least);
    rows += near * near * points.rows.middleCols<3>(static_cast<Index>(3 * i));
    sum += near * near;
  }
  rows /= sum;
}

// The displacement u there, and its gradient if it is asked for. u: of the points, x y z x y z.
Vector3d nearby_displacement(const ContactPoints& points, const VectorXd& u, const Vector3d& place,
                             Eigen::Matrix3d* gradient) {
  const double least = smallest_distance2(points);
  double sum = 0.0;
  Vector3d total = Vector3d::Zero(), slope = Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d from = place - points.rest[i];
    const double near = 1.0 / (from.squaredNorm() + least);
    const double weight = near * near;
    const Vector3d here = u.segment<3>(static_cast<Index>(3 * i));
    sum += weight;
    total += weight * here;
    if (gradient == nullptr) continue;
    const Vector3d change = (-4.0 * weight * near) * from;
    slope += change;
    spread += here * change.transpose();
  }
  const Vector3d mean = total / sum;
  if (gradient != nullptr) *gradient = (spread - mean * slope.transpose()) / sum;
  return mean;
}

// How far a place y of the body's frame is from its bent shape, by the place X at rest that is now
// there, X + u(X) = y, up to the third power of the strain.
struct BentDistance {
  double distance = 0.0;
  Vector3d gradient = Vector3d::Zero();  // by y
  Vector3d rest = Vector3d::Zero();
};

BentDistance bent_distance(const Collider& shape, const ContactPoints& points, const VectorXd& u,
                           const Vector3d& y) {
  BentDistance bent;
  bent.rest = y - nearby_displacement(points, u, y, nullptr);
  bent.rest = y - nearby_displacement(points, u, bent.rest, nullptr);
  Eigen::Matrix3d gradient;
  bent.rest = y - nearby_displacement(points, u, bent.rest, &gradient);
  const CollisionDistance found = signed_distance(shape, bent.rest);
  bent.distance = found.distance;
  bent.gradient = (Eigen::Matrix3d::Identity() + gradient).inverse().transpose() * found.normal;
  return bent;
}

}  // namespace

std::size_t add_pair_points(const ContactStep& first, const ContactStep& second, std::size_t a,
                            std::size_t b, std::vector<PairPoint>& points, std::size_t count) {
  const Collider* shape = second.shape();
  if (shape == nullptr) return count;
  const ContactPoints& on = first.points();
  const Pose from = first.poses().start, into = second.poses().start;
  const ContactLaw law = law_between(first, second);
  const double reach = law.margin + 2.0 * (first.ball().travel + second.ball().travel);
  const double bent = second.ball().deformed;
  const auto place = [&](const Vector3d& x) {
    return Vector3d(into.rotation.conjugate() * (x - into.position));
  };
  for (const PointGroup& group : on.groups) {
    const double far = group.radius + first.ball().deformed + bent + reach;
    if (signed_distance(*shape, place(from * group.centre)).distance > far) continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      const Vector3d y = place(from * on.place(i, first.q_start()));
      if (signed_distance(*shape, y).distance > reach + bent) continue;
      if (count == points.size()) points.emplace_back();
      PairPoint& pair = points[count];
      const BentDistance start = bent_distance(*shape, second.points(), second.u_start(), y);
      if (start.distance > reach) continue;
      nearby_rows(second.points(), start.rest, pair.rows);
      pair.gradient = start.gradient;
      pair.distance = start.distance;
      pair.energy = law.energy(start.distance);
      pair.a = a;
      pair.b = b;
      pair.point = i;
      pair.law = law;
      pair.now = {};
      ++count;
    }
  }
  return count;
}

// Gives each pair of members that touch a block of their own.
void ContactIsland::couple(std::span<PairPoint> points) {
  coupled_ = 0;
  for (PairPoint& pair : points) {
    const auto [low, high] = std::minmax(pair.a, pair.b);
    std::size_t k = 0;
    while (k < coupled_ && (couplings_[k].a != low || couplings_[k].b != high)) ++k;
    if (k == coupled_) {
      if (coupled_ == couplings_.size()) couplings_.emplace_back();
      couplings_[k].a = low;
      couplings_[k].b = high;
      const Index m = first_[low + 1] - first_[low], n = first_[high + 1] - first_[high];
      couplings_[k].ab.resize(m, n);
      couplings_[k].ba.resize(n, m);
      ++coupled_;
    }
    pair.coupling = k;
  }
}

// The residuals at the members' z; returns their size in units of what is small.
double ContactIsland::evaluate() {
  for (const IslandMember& member : members_) member.contact->evaluate();
  for (PairPoint& pair : points_) {
    ContactStep& first = *members_[pair.a].contact;
    ContactStep& second = *members_[pair.b].contact;
    const Collider& shape = *second.shape();
    pair.touch_a = first.touch_at_point(pair.point);
    const BentDistance end = bent_distance(shape, second.points(), second.u_end(),
                                           second.into_rest(pair.touch_a.x1, true));
    pair.now = {};
    pair.now.distance = end.distance;
    if (end.distance >= pair.law.margin && pair.distance >= pair.law.margin) continue;
    pair.touch_b = second.touch_by_other(pair.touch_a.x1, first.middle_of(pair.touch_a));
    pair.way_b = second.way_under(pair.touch_b, pair.rows);
    const Vector3d normal = second.turn_out(0.5 * (pair.gradient + end.gradient));
    pair.now = contact_force(pair.law, pair.distance, pair.energy, end.distance, normal,
                             pair.touch_a.x1 - pair.touch_a.x0 - pair.way_b, h_);
    if (pair.now.pressure == 0.0) continue;
    first.push_point(pair.now.force, pair.touch_a, pair.point);
    second.push_rows(-pair.now.force, pair.touch_b, pair.rows);
  }
  double square = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    sizes_[i] = members_[i].contact->close();
    const double share = sizes_[i] / enough_[i];
    square += share * share;
  }
  return std::sqrt(square);
}

void ContactIsland::add_pair(const PairPoint& pair) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  first.lever_at_point(pair.touch_a, pair.point);
  second.lever_at_rows(pair.touch_b, pair.rows);
  first.add_tangent(pair.now.stiffness);
  second.add_tangent(pair.now.stiffness);
  Coupling& coupling = couplings_[pair.coupling];
  const bool forward = pair.a < pair.b;
  (forward ? coupling.ab : coupling.ba).noalias() -=
      (first.lever_push() * pair.now.stiffness) * second.lever_way();
  (forward ? coupling.ba : coupling.ab).noalias() -=
      (second.lever_push() * pair.now.stiffness) * first.lever_way();
}

void ContactIsland::make_jacobian() {
  for (const IslandMember& member : members_) member.contact->make_jacobian();
  for (std::size_t k = 0; k < coupled_; ++k) {
    couplings_[k].ab.setZero();
    couplings_[k].ba.setZero();
  }
  for (const PairPoint& pair : points_)
    if (pair.now.pressure != 0.0) add_pair(pair);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Index n = first_[i + 1] - first_[i];
    residual_.segment(first_[i], n) = members_[i].contact->residual().head(n);
  }
}

bool ContactIsland::find_move_dense() {
  const Index all = first_[members_.size()];
  if (jacobian_.rows() != all) jacobian_.resize(all, all);
  jacobian_.setZero();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Index n = first_[i + 1] - first_[i];
    jacobian_.block(first_[i], first_[i], n, n) =
        members_[i].contact->jacobian().topLeftCorner(n, n);
  }
  for (std::size_t k = 0; k < coupled_; ++k) {
    const Coupling& c = couplings_[k];
    jacobian_.block(first_[c.a], first_[c.b], c.ab.rows(), c.ab.cols()) = c.ab;
    jacobian_.block(first_[c.b], first_[c.a], c.ba.rows(), c.ba.cols()) = c.ba;
  }
  factor_.compute(jacobian_);
  move_.head(all) = factor_.solve(residual_.head(all));
  return move_.head(all).allFinite();
}

bool ContactIsland::find_move_sparse() {
  const Index all = first_[members_.size()];
  triplets_.clear();
  const auto add = [this](Index row, Index column, const auto& block) {
    for (Index j = 0; j < block.cols(); ++j)
      for (Index i = 0; i < block.rows(); ++i)
        triplets_.emplace_back(static_cast<int>(row + i), static_cast<int>(column + j),
                               block(i, j));
  };
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Index n = first_[i + 1] - first_[i];
    add(first_[i], first_[i], members_[i].contact->jacobian().topLeftCorner(n, n));
  }
  for (std::size_t k = 0; k < coupled_; ++k) {
    add(first_[couplings_[k].a], first_[couplings_[k].b], couplings_[k].ab);
    add(first_[couplings_[k].b], first_[couplings_[k].a], couplings_[k].ba);
  }
  sparse_.resize(all, all);
  sparse_.setFromTriplets(triplets_.begin(), triplets_.end());
  sparse_factor_.compute(sparse_);
  if (sparse_factor_.info() != Eigen::Success) return false;
  move_.head(all) = sparse_factor_.solve(residual_.head(all));
  return move_.head(all).allFinite();
}

bool ContactIsland::solve(int& iterations) {
  const Index all = first_[members_.size()];
  double size = evaluate();
  for (iterations = 0; iterations < kMostIterations; ++iterations) {
    bool small = true;
    double square = 0.0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      enough_[i] = members_[i].contact->enough();
      small = small && sizes_[i] <= enough_[i];
      square += sizes_[i] * sizes_[i] / (enough_[i] * enough_[i]);
    }
    size = std::sqrt(square);
    if (small) return true;
    if (!std::isfinite(size)) return false;
    make_jacobian();
    if (!(all <= kDense ? find_move_dense() : find_move_sparse())) return false;
    for (std::size_t i = 0; i < members_.size(); ++i)
      z_before_.segment(first_[i], first_[i + 1] - first_[i]) =
          members_[i].contact->z().head(first_[i + 1] - first_[i]);
    const auto go = [this](double length) {
      for (std::size_t i = 0; i < members_.size(); ++i) {
        const Index n = first_[i + 1] - first_[i];
        members_[i].contact->z().head(n) =
            z_before_.segment(first_[i], n) - length * move_.segment(first_[i], n);
      }
      return evaluate();
    };
    double length = 1.0, next = 0.0;
    bool shorter = false;
    for (int k = 0; k <= kHalvings && !shorter; ++k, length *= 0.5) {
      next = go(length);
      shorter = next < (1.0 - 0.1 * length) * size;
    }
    // At rounding no move helps.
    if (!shorter && size <= 1e3) {
      go(0.0);
      return true;
    }
    size = next;
  }
  return false;
}

void ContactIsland::settle() {
  std::fill(accounts_.begin(), accounts_.end(), ContactAccount{});
  std::fill(starts_.begin(), starts_.end(), 0.0);
  for (const PairPoint& pair : points_) {
    ContactAccount& a = accounts_[pair.a];
    ContactAccount& b = accounts_[pair.b];
    starts_[pair.a] += pair.energy;
    a.energy += pair.now.energy;
    a.lost += pair.now.lost;
    a.rubbed += pair.now.rubbed;
    a.penetration = std::max(a.penetration, -pair.now.distance);
    if (pair.now.pressure == 0.0) continue;
    a.work += pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0);
    b.work -= pair.now.force.dot(pair.way_b);
    const double impulse = h_ * pair.now.force.norm();
    a.impulse += impulse;
    b.impulse += impulse;
    ++a.active;
    ++b.active;
  }
}

void ContactIsland::step(std::span<const IslandMember> members, std::span<PairPoint> points,
                         double h, std::span<StepReport> reports) {
  members_ = members;
  points_ = points;
  h_ = h;
  first_.assign(1, 0);
  for (const IslandMember& member : members) {
    member.contact->begin(*member.state, *member.load, member.free);
    first_.push_back(first_.back() + member.contact->unknowns());
  }
  const Index all = first_.back();
  if (residual_.size() < all) {
    residual_.resize(all);
    move_.resize(all);
    z_before_.resize(all);
  }
  enough_.assign(members.size(), 1.0);
  sizes_.assign(members.size(), 0.0);
  accounts_.resize(members.size());
  starts_.resize(members.size());
  couple(points);
  int iterations = 0;
  const bool converged = solve(iterations);
  if (converged) settle();
  for (std::size_t i = 0; i < members.size(); ++i) {
    StepReport& report = reports[i];
    report = {};
    report.converged = converged;
    report.iterations = iterations;
    report.residual = 0.5 * h * sizes_[i];
    if (!converged) continue;
    members[i].contact->settle_pairs(accounts_[i], starts_[i]);
    members[i].contact->finish(*members[i].state, report);
  }
}

}  // namespace tremolo
