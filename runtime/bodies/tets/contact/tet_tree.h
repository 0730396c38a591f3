// Finds the element of a deformed body that contains a position: the inverse of the map from the
// body at rest.
//
// An element's control points enclose it, because its polynomials are positive and add up to one.
// Therefore their boxes bound the element in any deformation; they form a tree over the elements
// whose structure is made once. In an element, sum_I B_I(w) x_I = place is solved for w by Newton's
// method with the element's deformation gradient, in one step if the element is straight.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

// A position in an element.
struct TetPlace {
  std::uint32_t element = 0;
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();       // barycentric coordinates in the element
  std::array<double, kMostNodes> values{};                 // B_I there
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();  // F there
};

// Distance outside all elements, in barycentric coordinates, up to which a position still counts as
// inside: a surface at rest may extend slightly beyond its mesh.
inline constexpr double kOutsideShare = 0.05;

class TetTree {
 public:
  using Box = Eigen::AlignedBox3d;

  explicit TetTree(TetModelPointer model);

  // Number of boxes that fit() computes; the first is that of the whole body.
  std::size_t size() const { return items_.size(); }
  // x: control points. boxes: size() of them. Allocates nothing.
  void fit(const Eigen::VectorXd& x, std::vector<Box>& boxes) const;

  // Finds the element in which the position is deepest. Empty: no element contains it; flat and
  // inverted elements contain nothing. Allocates nothing.
  std::optional<TetPlace> find(const Eigen::VectorXd& x, const std::vector<Box>& boxes,
                               const Eigen::Vector3d& place) const;

  // The coordinates of a position in one element. Empty: Newton's method does not converge, or near
  // convergence one coordinate will be less than `least`.
  std::optional<TetPlace> solve(std::uint32_t element, const Eigen::VectorXd& x,
                                const Eigen::Vector3d& place, double least) const;
  // The position at rest.
  Eigen::Vector3d rest_place(const TetPlace& place) const;
  // F of the body there, continuous between elements: linear in the element between the means of F
  // at its vertices, by volume, over all elements around each. Allocates nothing.
  Eigen::Matrix3d smooth_gradient(const TetPlace& place, const Eigen::VectorXd& x) const;
  std::size_t bytes() const {
    return items_.capacity() * sizeof(Item) +
           (firsts_.capacity() + around_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  // A node of the tree; its first child follows it.
  struct Item {
    std::uint32_t second = 0;
    std::uint32_t element = 0;  // of a leaf
    bool leaf = false;
  };
  void split(std::span<std::uint32_t> elements);
  void find_around();
  Eigen::Matrix3d vertex_gradient(std::uint32_t vertex, const Eigen::VectorXd& x) const;

  TetModelPointer model_;
  std::vector<Item> items_;
  // The elements around vertex v are around_[firsts_[v]] to around_[firsts_[v + 1] - 1].
  std::vector<std::uint32_t> firsts_, around_;
  std::vector<Eigen::Vector3d> middles_;  // of elements at rest; only while it is made
};

}  // namespace tremolo
