#include "runtime/contact/solve/contact_island.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/contact/solve/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostIterations = 120;

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

// How far a place y of the body's frame is from its bent shape: by the place X at rest that is now
// there nearly, X1 = y - u(y), X = y - u(X1).
struct BentDistance {
  double distance = 0.0;
  Vector3d gradient = Vector3d::Zero();  // by y
};

// level: without the gradient if it is farther.
BentDistance bent_distance(const Collider& shape, const ContactPoints& points, const VectorXd& u,
                           const Vector3d& y, double level) {
  BentDistance bent;
  Eigen::Matrix3d first, second;
  const Vector3d rest1 = y - nearby_displacement(points, u, y, nullptr);
  const Vector3d rest = y - nearby_displacement(points, u, rest1, nullptr);
  const CollisionDistance found = signed_distance(shape, rest);
  bent.distance = found.distance;
  if (found.distance > level) return bent;
  nearby_displacement(points, u, y, &first);
  nearby_displacement(points, u, rest1, &second);
  const Vector3d through = second.transpose() * found.normal;
  bent.gradient = found.normal - through + first.transpose() * through;
  return bent;
}

// How that distance changes with the coordinates, r: -n.(N(X1) - (grad u)(X1) N(y)), N the rows of
// U.
void bent_change(const Collider& shape, const ContactPoints& points, const VectorXd& u,
                 const Vector3d& y, Eigen::MatrixX3d& first, Eigen::MatrixX3d& second,
                 VectorXd& change) {
  Eigen::Matrix3d gradient;
  const Vector3d rest1 = y - nearby_displacement(points, u, y, nullptr);
  const Vector3d rest = y - nearby_displacement(points, u, rest1, &gradient);
  const Vector3d n = signed_distance(shape, rest).normal;
  nearby_rows(points, y, first);
  nearby_rows(points, rest1, second);
  change.noalias() = first * (gradient.transpose() * n) - second * n;
}

// The transposed rows R, r x 3, by which that place moves with the coordinates, so that the
// distance changes by gradient.(dy - R^T dq): those of nearby_rows() but for what bends.
void bent_rows(const ContactPoints& points, const VectorXd& u, const Vector3d& y,
               Eigen::MatrixX3d& first, Eigen::MatrixX3d& rows) {
  Eigen::Matrix3d at_y, at_rest1;
  const Vector3d rest1 = y - nearby_displacement(points, u, y, &at_y);
  nearby_displacement(points, u, rest1, &at_rest1);
  nearby_rows(points, y, first);
  nearby_rows(points, rest1, rows);
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d by_y = unit - at_rest1 * (unit - at_y);
  rows -= first * at_rest1.transpose();
  rows *= by_y.inverse().transpose();
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
      const BentDistance start = bent_distance(*shape, second.points(), second.u_start(), y, reach);
      if (start.distance > reach) continue;
      bent_rows(second.points(), second.u_start(), y, pair.near, pair.rows);
      pair.place_at_start = y;
      pair.gradient = start.gradient;
      pair.distance = start.distance;
      pair.energy = law.energy(start.distance);
      pair.a = a;
      pair.b = b;
      pair.point = i;
      pair.law = law;
      pair.now = {};
      pair.held = {};
      pair.fresh = true;
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
double ContactIsland::evaluate(double renew) {
  bends_.clear();
  for (const IslandMember& member : members_) {
    member.contact->evaluate(renew);
    bends_.push_back(member.contact->bend_in_step());
  }
  for (PairPoint& pair : points_) {
    ContactStep& first = *members_[pair.a].contact;
    ContactStep& second = *members_[pair.b].contact;
    const Collider& shape = *second.shape();
    pair.touch_a = first.touch_at_point(pair.point);
    pair.place = second.into_rest(pair.touch_a.x1, true);
    // Too far for d1 to be within the margin, if its gradient is shorter than 2.
    const double nearer = 2.0 * ((pair.place - pair.place_at_start).norm() + bends_[pair.b]);
    if (pair.distance - nearer > pair.law.margin && pair.held.grinding == 0.0) {
      pair.now = {};
      pair.now.distance = pair.distance;
      continue;
    }
    const bool acts = pair.distance < pair.law.margin || pair.held.grinding != 0.0;
    const double level = acts ? std::numeric_limits<double>::infinity() : pair.law.margin;
    const BentDistance end =
        bent_distance(shape, second.points(), second.u_end(), pair.place, level);
    pair.now = {};
    pair.now.distance = end.distance;
    if (!acts && end.distance >= pair.law.margin) continue;
    pair.touch_b = second.touch_by_other(pair.touch_a.x1, first.middle_of(pair.touch_a));
    pair.way_b = second.way_under(pair.touch_b, pair.rows);
    const Vector3d way = pair.touch_a.x1 - pair.touch_a.x0 - pair.way_b;
    pair.slope = second.turn_out_at_end(end.gradient);
    if (renew > 0.0 || pair.fresh)
      pair.held.normal = second.turn_out(0.5 * (pair.gradient + end.gradient));
    pair.fresh = false;
    const auto force = [&] {
      return contact_force(pair.law, pair.distance, pair.energy, end.distance, way, h_, pair.held);
    };
    pair.now = force();
    if (renew > 0.0) {
      pair.held.grinding += renew * (pair.now.grinding - pair.held.grinding);
      pair.now = force();
    }
    if (!pair.now.acts) continue;
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

// How the pair's force falls with the unknowns of its bodies, by d1 and by the way.
void ContactIsland::find_changes(const PairPoint& pair) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  const Index m = first.unknowns(), n = second.unknowns();
  const Index r = second.turns() ? n - 6 : n;
  change_a_.resize(3, m);
  change_b_.resize(3, n);
  const Eigen::Matrix3d all = pair.now.fall * pair.slope.transpose() + pair.now.stiffness;
  change_a_.noalias() = all * first.lever_way();
  bent_change(*second.shape(), second.points(), second.u_end(), pair.place, near_first_,
              near_second_, by_q_);
  change_b_.noalias() =
      -pair.now.stiffness * second.change_of_way(pair.touch_b, pair.rows).leftCols(n);
  change_b_.leftCols(r).noalias() += pair.now.fall * by_q_.transpose();
  if (second.turns())
    change_b_.rightCols<6>().noalias() -=
        pair.now.fall * (pair.slope.transpose() * second.lever_way().rightCols<6>());
}

void ContactIsland::add_pair(const PairPoint& pair) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  first.lever_at_point(pair.touch_a, pair.point);
  second.lever_at_rows(pair.touch_b, pair.rows);
  find_changes(pair);
  first.add_pushed(change_a_, 1.0);
  second.add_pushed(change_b_, -1.0);
  first.add_geometry(pair.now.force, pair.touch_a, pair.point);
  second.add_geometry_of_other(-pair.now.force, pair.touch_b, pair.rows);
  Coupling& coupling = couplings_[pair.coupling];
  const bool forward = pair.a < pair.b;
  (forward ? coupling.ab : coupling.ba).noalias() += first.lever_push() * change_b_;
  (forward ? coupling.ba : coupling.ab).noalias() -= second.lever_push() * change_a_;
  // The torque on the second acts where the first's point is.
  if (!second.turns()) return;
  const Index turn = second.unknowns() - 6;
  (forward ? coupling.ba : coupling.ab).middleRows<3>(turn).noalias() +=
      second.turn_of_arm(-pair.now.force) * second.rotation_at_start().transpose() *
      first.path_of_middle().leftCols(first.unknowns());
}

void ContactIsland::make_jacobian(double heavier) {
  for (const IslandMember& member : members_) member.contact->make_jacobian(heavier);
  for (std::size_t k = 0; k < coupled_; ++k) {
    couplings_[k].ab.setZero();
    couplings_[k].ba.setZero();
  }
  for (const PairPoint& pair : points_)
    if (pair.now.acts) add_pair(pair);
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
  evaluate(0.0);
  double size = 0.0, heavier = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i)
    size = std::max(size, sizes_[i] / members_[i].contact->enough());
  for (iterations = 0; iterations < kMostIterations; ++iterations) {
    if (const double renew = renewal(iterations, size); renew > 0.0) evaluate(renew);
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
    for (std::size_t i = 0; i < members_.size(); ++i)
      z_before_.segment(first_[i], first_[i + 1] - first_[i]) =
          members_[i].contact->z().head(first_[i + 1] - first_[i]);
    const auto slope = [this] {
      double work = 0.0;
      for (std::size_t i = 0; i < members_.size(); ++i)
        work +=
            members_[i].contact->work_along(move_.segment(first_[i], first_[i + 1] - first_[i]));
      return -work;
    };
    const auto go = [&](double length) {
      for (std::size_t i = 0; i < members_.size(); ++i) {
        const Index n = first_[i + 1] - first_[i];
        members_[i].contact->z().head(n) =
            z_before_.segment(first_[i], n) - length * move_.segment(first_[i], n);
      }
      const double next = evaluate(0.0);
      return LineTrial{next, slope()};
    };
    const auto find_move = [&](double added) {
      make_jacobian(added);
      const bool found = all <= kDense ? find_move_dense() : find_move_sparse();
      return found ? slope() : 0.0;
    };
    LineTrial reached;
    const bool near = size <= 1e3;
    if (!newton_move(find_move, go, size, near, heavier, reached)) return near;
    // At rounding no move helps.
    if (!(reached.size < 0.9 * size) && near) {
      if (reached.size > size) go(0.0);
      return true;
    }
    size = reached.size;
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
    if (!pair.now.acts) continue;
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
