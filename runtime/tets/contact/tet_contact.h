// A body of tetrahedra touches solids that stand still and other bodies, at points of its surface
// (tet_points.h). With the signed distance d of a solid at the point and its outward normal n,
//   f = k <-d> n  -  mu k <-d> v_t / sqrt(|v_t|^2 + v_0^2),     v_t = v - (v.n) n,
// <a> = max(a, 0), v the point's velocity against the solid. The first part has the potential
// 1/2 k <-d>^2, the second only takes energy, and below v_0 is a creep. What sticks is as stiff as
// mu k <-d> / (v_0 h) for a step h: a larger v_0 is easier to solve. A penalty: under a load F a
// point is F/k deep.
//
// The distance d of another body is its distance at rest, phi, at the place X that its bent
// elements put at the point (tet_tree.h): x = sum_I B_I(X) x_I, so that with F = dx/dX
//   d phi = g . (dx - sum_I B_I dx_I),     g = F^-T grad phi,
// and f = -k phi g pushes the point, -B_I f the other body's control points: the slope of
// 1/2 k phi^2 exactly, at one place, so that momentum and angular momentum are kept. Where two
// points press on each other k is that of both in a row. Changes of g are left out of the
// stiffness, which is then k g g^T, never negative.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/distance/distance_grid.h"
#include "runtime/contact/collider.h"
#include "runtime/frames/pose.h"
#include "runtime/tets/contact/tet_points.h"
#include "runtime/tets/contact/tet_tree.h"
#include "runtime/tets/elements/tet_system.h"
#include "runtime/tets/solve/active_solve.h"

namespace tremolo {

// What bodies of one kind touch with and are touched by. grid: distances at rest; without it the
// points of others go through. stiffness: the mean of the points', N/m.
struct TetHull {
  TetHull(TetModelPointer of, std::vector<TetPoint> with, std::optional<DistanceGrid> distances);

  TetModelPointer model;
  std::vector<TetPoint> points;
  std::optional<DistanceGrid> grid;
  TetTree tree;
  double stiffness = 0.0;

  std::size_t bytes() const;
};
using TetHullPointer = std::shared_ptr<const TetHull>;
// The hull of the mesh's boundary, without distances.
TetHullPointer boundary_hull(TetModelPointer model);

// friction: mu of the pair.
struct TetObstacle {
  Collider shape;
  Pose pose;
  double friction = 0.3;
};

inline constexpr double kTetCreep = 1e-3;  // v_0 unless told, m/s

class TetContact;

// Another body that is near. member: its number in the island (tet_island.h). s, v: its control
// points where forces are taken. friction: of the pair.
struct TetPartner {
  std::uint32_t member = 0;
  const TetContact* contact = nullptr;
  const Eigen::VectorXd* s = nullptr;
  const Eigen::VectorXd* v = nullptr;
  double friction = 0.3;
};

inline constexpr std::uint32_t kNoPartner = ~std::uint32_t{0};

// A point that touches. partner: which, kNoPartner of what stands still, which is then `obstacle`;
// nodes, values: the partner's control points there. slope: g. stiffness: k, N/m. force: on the
// point, N. place, speed: -df/dx and -df/dv between point and partner. energy: of the penalty, J.
struct TetTouch {
  std::uint32_t point = 0;
  std::uint32_t partner = kNoPartner;
  std::uint32_t obstacle = 0;
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<double, kMostNodes> values{};
  double depth = 0.0, stiffness = 0.0, energy = 0.0;
  Eigen::Vector3d slope;
  Eigen::Vector3d force;
  Eigen::Matrix3d place, speed;
};

class TetContact {
 public:
  // creep: v_0 of the body's points, m/s, above 0.
  TetContact(TetHullPointer hull, std::vector<TetObstacle> obstacles, double creep = kTetCreep);

  const TetHull& hull() const { return *hull_; }
  // Who is near, in an order that is kept. Bodies without distances are passed over.
  void clear_partners() { partners_.clear(); }
  void add_partner(const TetPartner& partner) { partners_.push_back(partner); }
  std::span<const TetPartner> partners() const { return partners_; }

  // The boxes of the body's elements at x: before anything is looked for.
  void fit(const Eigen::VectorXd& x);
  const TetTree::Box& box() const { return boxes_.front(); }

  // Finds what the points touch at places s with velocities v; it and its partners have been
  // fitted. Where none of them has moved since the last time, as between the end of a step and the
  // beginning of the next, places are those that were found. May be called for several bodies at
  // once.
  void find(const Eigen::VectorXd& s, const Eigen::VectorXd& v);
  std::span<const TetTouch> touches() const { return touches_; }

  // f += the forces on the body's own control points, not folded.
  void add_forces(Eigen::VectorXd& f) const;
  // f += what its touches of one partner do to that.
  void add_partner_forces(std::uint32_t partner, Eigen::VectorXd& f) const;

  // What was found last: what the penalty stores, J; the depth of the deepest point, m; how many
  // touch.
  struct Look {
    double energy = 0.0, depth = 0.0;
    std::size_t touching = 0;
  };
  Look look() const;
  // Looks likewise at what stands still alone, at places x.
  Look look(const Eigen::VectorXd& x) const;
  std::size_t bytes() const;

 private:
  struct Fitted {
    const TetContact* contact = nullptr;
    std::uint64_t times = 0;
    bool operator==(const Fitted&) const = default;
  };
  bool places_are_known();
  void find_places(const Eigen::VectorXd& s);
  void find_obstacles(std::uint32_t p, const Eigen::Vector3d& place);
  void find_partner(std::uint32_t p, const Eigen::Vector3d& place, std::uint32_t number);

  TetHullPointer hull_;
  double creep_;
  std::vector<TetObstacle> obstacles_;
  std::vector<TetPartner> partners_;
  std::vector<TetTree::Box> boxes_;
  std::vector<TetTouch> touches_;
  std::vector<std::uint8_t> near_;  // of the obstacles, which the body's box reaches
  Eigen::VectorXd fitted_;          // x of fit()
  std::uint64_t times_ = 0;         // how often that was another one
  std::vector<Fitted> known_;       // itself and its partners, when places were found
};

}  // namespace tremolo
