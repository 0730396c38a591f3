// The dense products of the precompute, by BLAS. Eigen's own are compiled for plain x86-64, a
// quarter of what the machine can do.
#pragma once

#include <Eigen/Core>

namespace tremolo {

using ColumnsRef = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ColumnsOut = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

// A^T B.
Eigen::MatrixXd transposed_product(const ColumnsRef& a, const ColumnsRef& b);

// C <- alpha A B + beta C. C overlaps neither A nor B.
void add_product(double alpha, const ColumnsRef& a, const ColumnsRef& b, double beta, ColumnsOut c);

}  // namespace tremolo
