// Dense products of the precompute, by BLAS. Eigen's own products are compiled for plain x86-64 and
// reach a quarter of the machine's speed.
#pragma once

#include <Eigen/Core>

namespace tremolo {

using ColumnsRef = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ColumnsOut = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

// Returns A^T B.
Eigen::MatrixXd transposed_product(const ColumnsRef& a, const ColumnsRef& b);

// Computes C <- alpha A B + beta C. C must overlap neither A nor B.
void add_product(double alpha, const ColumnsRef& a, const ColumnsRef& b, double beta, ColumnsOut c);

}  // namespace tremolo
