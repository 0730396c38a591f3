// Winding number of a set of triangles about a point: 1 inside a closed surface that is oriented
// outwards, 0 outside, a value between where there are holes (Jacobson, Kavan and Sorkine-Hornung
// 2013, eq. 4). Far triangles are combined into their dipole (Barill et al. 2018, eq. 6). CGAL's
// Side_of_triangle_mesh handles closed surfaces only.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

class WindingNumber {
 public:
  // Copies the data that it needs.
  explicit WindingNumber(const SurfaceMesh& surface);

  // Exact for near triangles; the far ones add an error of a few thousandths, 0.05 at most.
  double at(const Eigen::Vector3d& x) const;

  // Cost of at() there: the number of triangles and nodes that it visits.
  std::size_t cost_at(const Eigen::Vector3d& x) const;

 private:
  // Goes through the tree for x: far(node), near(triangle).
  template <class Far, class Near>
  void visit(const Eigen::Vector3d& x, const Far& far, const Near& near) const;
  struct Node {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();      // of the area
    Eigen::Vector3d dipole = Eigen::Vector3d::Zero();      // sum of area times normal
    Eigen::Matrix3d quadrupole = Eigen::Matrix3d::Zero();  // sum of (x - centre) (area n)^T
    double radius = 0;
    std::size_t first = 0, last = 0;  // triangles
    std::size_t right = 0;            // the left child is next; 0: a leaf
  };
  using Corners = Eigen::Matrix3d;  // columns: the corners of a triangle

  std::size_t build(std::size_t first, std::size_t last);

  std::vector<Corners> triangles_;  // in the order of the leaves
  std::vector<Node> nodes_;
};

}  // namespace tremolo
