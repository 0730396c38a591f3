#include "runtime/math/dense/small_matrices.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// Entries by columns, `stride` apart; rows: the number to compute, a multiple of eight.
struct TallRows {
  const double* entries;
  std::size_t stride;
  std::size_t rows;
  std::size_t columns;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/dense/tall_product.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

TallRows rows_of(const Eigen::MatrixXd& a, Eigen::Index rows) {
  return {a.data(), static_cast<std::size_t>(a.rows()), padded(static_cast<std::size_t>(rows)),
          static_cast<std::size_t>(a.cols())};
}

}  // namespace

Eigen::Index tall_rows(Eigen::Index rows) {
  return static_cast<Eigen::Index>(padded(static_cast<std::size_t>(rows)));
}

void multiply_tall(const Eigen::MatrixXd& a, Eigen::Index rows, const Eigen::VectorXd& x,
                   Eigen::VectorXd& y) {
  TREMOLO_CALL(multiply_rows, rows_of(a, rows), x.data(), y.data());
}

void add_blocks(const Eigen::MatrixXd& a, std::span<const double> weights, Eigen::MatrixXd& sum) {
  TREMOLO_CALL(sum_blocks, rows_of(a, a.cols()), weights.data(), weights.size(), sum.data());
}

}  // namespace tremolo
