// A body of tetrahedra touches solids that stand still: at each point of its boundary, the vertices
// and the edges' middles, with signed distance d and outward normal n of the solid,
//   f = k <-d> n  -  mu k <-d> v_t / sqrt(|v_t|^2 + v_0^2),     v_t = v - (v.n) n,
// with <a> = max(a, 0). The first part has the potential 1/2 k <-d>^2, the second only takes
// energy, and below v_0 is a creep. k is twice the stiffness of the point's own row at rest, so
// that a body sinks in by about as much as it bends there, and the system's condition stays.
// A penalty: under a load F a point is F/k deep.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/contact/collider.h"
#include "runtime/frames/pose.h"
#include "runtime/tets/tet_body.h"

namespace tremolo {

// friction: mu of the pair.
struct TetObstacle {
  Collider shape;
  Pose pose;
  double friction = 0.3;
};

inline constexpr double kTetCreep = 1e-3;  // v_0, m/s

class TetContact : public TetPushes {
 public:
  // All memory is taken here.
  TetContact(const TetModel& model, std::vector<TetObstacle> obstacles);

  void add_forces(const Eigen::VectorXd& s, const Eigen::VectorXd& v, Eigen::VectorXd& f) override;
  void add_stiffness(const TetSystem& system, double velocity_rate, BlockMatrix& a) override;

  // At places x: what the penalty stores, J; the depth of the deepest point, m; how many touch.
  struct Look {
    double energy = 0.0, depth = 0.0;
    std::size_t touching = 0;
  };
  Look look(const Eigen::VectorXd& x) const;

 private:
  // A point: sum of shares times control points; an edge's middle has three, a vertex one.
  struct Point {
    std::array<std::uint32_t, 3> nodes{};
    std::array<double, 3> shares{};
    int count = 1;
    double stiffness = 0.0;  // N/m
  };
  // A point that touches: -df/ds, -df/dv without the change of n along the solid.
  struct Touch {
    std::uint32_t point = 0;
    Eigen::Matrix3d place, speed;
  };
  static Eigen::Vector3d at(const Point& point, const Eigen::VectorXd& x);

  std::vector<Point> points_;
  std::vector<TetObstacle> obstacles_;
  std::vector<Touch> touches_;
};

}  // namespace tremolo
