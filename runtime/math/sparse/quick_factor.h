// A factor that preconditions a solve: of floats where their digits are enough, else of doubles.
#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/sparse/block_cholesky.h"

namespace tremolo {

class QuickFactor {
 public:
  // Same errors as BlockFactor::create().
  static Result<QuickFactor> create(BlockPatternPointer pattern, std::size_t most_bytes) {
    Result<BlockFactor<float>> made = BlockFactor<float>::create(pattern, most_bytes / 2);
    if (!made) return made.error();
    return QuickFactor(std::move(pattern), std::move(*made));
  }

  // True: there is a factor of `a`. False: `a` is not positive definite. The first matrix whose
  // pivots lose more digits than floats have to spare makes room for a factor of doubles, which
  // serves from then on; otherwise nothing is allocated except an error's message.
  bool factor(const BlockMatrix& a) {
    constexpr double kLeastPivot = 1e-4;
    if (!exact_) {
      const bool good = static_cast<bool>(quick_.factor(a));
      if (std::abs(quick_.weakest_pivot()) > kLeastPivot) return good;
      Result<BlockCholesky> made = BlockCholesky::create(pattern_);
      if (!made) return good;
      exact_.emplace(std::move(*made));
    }
    return static_cast<bool>(exact_->factor(a));
  }

  // x <- near A^-1 x for the last factored matrix, linear in x.
  void solve(Eigen::VectorXd& x) {
    if (exact_)
      exact_->solve(x);
    else
      quick_.solve(x);
  }

  bool in_floats() const { return !exact_; }

 private:
  QuickFactor(BlockPatternPointer pattern, BlockFactor<float> quick)
      : pattern_(std::move(pattern)), quick_(std::move(quick)) {}

  BlockPatternPointer pattern_;
  BlockFactor<float> quick_;
  std::optional<BlockCholesky> exact_;
};

}  // namespace tremolo
