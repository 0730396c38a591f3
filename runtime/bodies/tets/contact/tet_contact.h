// Contact of a body of tetrahedra with fixed solids and other bodies, at points of its surface.
// With the signed distance d of a solid at the point and its outward normal n,
//   f = k <-d> n - k xi,     xi = clip(xi_0 + t),     clip(x) = x min(1, l/|x|),     l = mu <-d>,
// <a> = max(a, 0). t is the path of the point along the solid since the start of the step, and xi_0
// the elastic displacement of friction then, both in the plane of n. The first part has the
// potential 1/2 k <-d>^2. The second is a spring with a slider, whose memory xi lasts from step to
// step: a point that sticks does not creep. This is a penalty: under a load F a point penetrates by
// F/k.
//
// For another body, d is its distance at rest, phi, at the point X that its deformed elements map
// to the contact point (tet_tree.h): x = sum_I B_I(X) x_I, so that with F = dx/dX
//   d phi = g . (dx - sum_I B_I dx_I),     g = F^-T grad phi,
// and f = -k phi g acts on the point, -B_I f on the other body's control points. This is the exact
// slope of 1/2 k phi^2, at one position, so that momentum and angular momentum are conserved. Where
// two points press on each other, k is that of both springs in series. Changes of g are left out of
// the stiffness, which is then k g g^T, never negative.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/distance/distance_grid.h"
#include "formats/tets/tets_file.h"
#include "runtime/bodies/tets/contact/tet_tree.h"
#include "runtime/bodies/tets/elements/tet_model.h"
#include "runtime/bodies/tets/elements/tet_system.h"
#include "runtime/bodies/tets/solve/active_solve.h"
#include "runtime/contact/collider.h"
#include "runtime/math/pose.h"

namespace tremolo {

// A contact point.
struct TetPoint {
  std::uint32_t count = 0;
  // Control points of one element; both ends of an edge are included if its control point is.
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<double, kMostNodes> shares{};  // weights
  // Twice the mean stiffness at rest of the rows of these nodes by their weights, N/m. A body then
  // penetrates about as much as it deforms there, and the system's condition is unchanged.
  double stiffness = 0.0;
};

// The weighted sum of x, any vector of the control points.
Eigen::Vector3d at_point(const TetPoint& point, const Eigen::VectorXd& x);

// The vertices of the mesh's boundary and the midpoints of its edges.
std::vector<TetPoint> boundary_points(const TetModel& model);

// Vertices of a surface attached to the body, in their order, thinned evenly if there are more than
// the mesh's boundary has vertices and edges.
std::vector<TetPoint> surface_points(const TetModel& model, const TetsSurface& surface);

// The contact surface that all bodies of one kind have.
struct TetHull {
  TetHull(TetModelPointer of, std::vector<TetPoint> with, std::optional<DistanceGrid> distances);

  TetModelPointer model;
  std::vector<TetPoint> points;
  // Distances at rest; without it the points of other bodies pass through.
  std::optional<DistanceGrid> grid;
  TetTree tree;
  double stiffness = 0.0;  // mean of the points' stiffness, N/m

  std::size_t bytes() const;
};
using TetHullPointer = std::shared_ptr<const TetHull>;
// The hull of the mesh's boundary, without distances.
TetHullPointer boundary_hull(TetModelPointer model);

// A fixed obstacle.
struct TetObstacle {
  Collider shape;
  Pose pose;
  double friction = 0.3;  // mu of the pair
};

class TetContact;

// Another body nearby.
struct TetPartner {
  std::uint32_t member = 0;  // its number in the island (tet_island.h)
  std::uint32_t body = 0;    // its number, the same in all steps
  const TetContact* contact = nullptr;
  const Eigen::VectorXd* s = nullptr;     // its control points where forces are evaluated, m
  const Eigen::VectorXd* from = nullptr;  // at the start of the step, m
  double friction = 0.3;                  // of the pair
};

inline constexpr std::uint32_t kNoPartner = ~std::uint32_t{0};

// A point in contact.
struct TetTouch {
  std::uint32_t point = 0;
  std::uint32_t partner = kNoPartner;             // kNoPartner for a fixed obstacle
  std::uint32_t obstacle = 0;                     // without a partner
  std::array<std::uint32_t, kMostNodes> nodes{};  // the partner's control points there
  std::array<double, kMostNodes> values{};        // their weights
  // depth: m. stiffness: k, N/m. energy: of the penalty and of friction's spring, J.
  double depth = 0.0, stiffness = 0.0, energy = 0.0;
  Eigen::Vector3d slope;                               // g
  Eigen::Matrix3d bend = Eigen::Matrix3d::Identity();  // F of the partner at the position
  double limit = 0.0;                                  // l, m
  Eigen::Vector3d path;                                // t, m
  Eigen::Vector3d trial;                               // xi_0 + t, m
  Eigen::Vector3d force;                               // on the point, N
  Eigen::Matrix3d fall;  // -df/dx, of the point relative to the partner, N/m
};

// The displacement of friction between steps, of a point that was in contact. Vectors are along the
// world's axes at a fixed obstacle, and along those of the partner at rest, turned with it.
struct TetFriction {
  std::uint32_t point = 0;
  bool on_body = false;
  std::uint32_t obstacle = 0;  // number of the obstacle, or of the other body
  Eigen::Vector3d slip;        // xi, m
  Eigen::Vector3d normal;      // of its plane, length 1
};

class TetContact {
 public:
  TetContact(TetHullPointer hull, std::vector<TetObstacle> obstacles);

  const TetHull& hull() const { return *hull_; }
  // The bodies nearby, in a fixed order. Bodies without distances are skipped.
  void clear_partners() { partners_.clear(); }
  void add_partner(const TetPartner& partner) { partners_.push_back(partner); }
  std::span<const TetPartner> partners() const { return partners_; }

  // Fits the boxes of the body's elements to x; call it before any search.
  void fit(const Eigen::VectorXd& x);
  const TetTree::Box& box() const { return boxes_.front(); }

  // Finds the contacts of the points at positions s in a step that began at positions `from`; the
  // body and its partners have been fitted. If none of them has moved since the last call, as
  // between the end of a step and the start of the next, the positions in the partners are reused.
  // May be called for several bodies at once.
  void find(const Eigen::VectorXd& s, const Eigen::VectorXd& from);
  std::span<const TetTouch> touches() const { return touches_; }

  // Ends a step at the contacts last found: friction remembers its displacements. whole: the path
  // of the step over that to the positions at which forces are evaluated.
  void end_step(double whole);
  // Forgets all displacements of friction, or those on one other body (TetPartner::body).
  void forget() { memory_.clear(); }
  void forget_body(std::uint32_t body);
  // Friction's memory at the start of a step, and of a part of one, to which it may return.
  void keep_memory() { kept_memory_ = memory_; }
  void restore_memory() { memory_ = kept_memory_; }
  void keep_part() { part_memory_ = memory_; }
  void rewind_part() { memory_ = part_memory_; }

  // f += the forces on the body's own control points, not condensed.
  void add_forces(Eigen::VectorXd& f) const;
  // f += the forces of its contacts with one partner on that partner.
  void add_partner_forces(std::uint32_t partner, Eigen::VectorXd& f) const;

  // Statistics of the last search.
  struct Look {
    // energy: of the penalty, J. depth: of the deepest point, m.
    double energy = 0.0, depth = 0.0;
    std::size_t touching = 0;  // number of points in contact
  };
  Look look() const;
  // The same for fixed obstacles alone, at positions x.
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

  const TetFriction* remembered(const TetTouch& touch) const;
  std::uint32_t number_of(const TetTouch& touch) const;

  TetHullPointer hull_;
  std::vector<TetObstacle> obstacles_;
  std::vector<TetPartner> partners_;
  std::vector<TetTree::Box> boxes_;
  std::vector<TetTouch> touches_;
  std::vector<TetFriction> memory_;  // ascending by point
  std::vector<TetFriction> kept_memory_, part_memory_;
  std::vector<std::uint8_t> near_;  // the obstacles that the body's box reaches
  Eigen::VectorXd fitted_;          // x of the last fit()
  std::uint64_t times_ = 0;         // number of fits with another x
  std::vector<Fitted> known_;       // the body and its partners when positions were last found
};

}  // namespace tremolo
