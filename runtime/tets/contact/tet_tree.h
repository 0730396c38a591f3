// Which element of a bent body holds a place: the inverse of the map from the body at rest.
//
// An element's control points enclose it (its polynomials are positive and add up to one), so that
// their boxes, in a tree over the elements whose shape is made once, hold whatever the element
// does. In an element, sum_I B_I(w) x_I = place is solved for w by Newton's method with the
// element's deformation gradient, in one step where it is straight.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

// weights: barycentric coordinates in the element. values: B_I there. gradient: F there.
struct TetPlace {
  std::uint32_t element = 0;
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();
  std::array<double, kMostNodes> values{};
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
};

// So far outside of all elements a place still counts as held, in barycentric coordinates: a
// surface at rest may stand out of its mesh by a little.
inline constexpr double kOutsideShare = 0.05;

class TetTree {
 public:
  using Box = Eigen::AlignedBox3d;

  explicit TetTree(TetModelPointer model);

  // How many boxes fit() fills; the first is that of the whole body.
  std::size_t size() const { return items_.size(); }
  // x: control points. boxes: size() of them. Allocates nothing.
  void fit(const Eigen::VectorXd& x, std::vector<Box>& boxes) const;

  // Finds the element in which the place lies deepest. Nothing where none holds it; flat
  // and inverted elements hold nothing. Allocates nothing.
  std::optional<TetPlace> find(const Eigen::VectorXd& x, const std::vector<Box>& boxes,
                               const Eigen::Vector3d& place) const;

  // The coordinates of a place in one element; nothing where Newton's method does not converge, or
  // where it is nearly there and one of them will be less than `least`.
  std::optional<TetPlace> solve(std::uint32_t element, const Eigen::VectorXd& x,
                                const Eigen::Vector3d& place, double least) const;
  // The place at rest.
  Eigen::Vector3d rest_place(const TetPlace& place) const;
  std::size_t bytes() const { return items_.capacity() * sizeof(Item); }

 private:
  // Its first child comes next. element: of a leaf.
  struct Item {
    std::uint32_t second = 0;
    std::uint32_t element = 0;
    bool leaf = false;
  };
  void split(std::vector<std::uint32_t>& elements, std::size_t begin, std::size_t end);

  TetModelPointer model_;
  std::vector<Item> items_;
  std::vector<Eigen::Vector3d> middles_;  // of elements at rest; only while it is made
};

}  // namespace tremolo
