// A factor that preconditions a solve: of floats where their digits are enough, else of doubles.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

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

  // True: there is a factor of `a`, of doubles if the pivots lose more digits than floats have to
  // spare. This depends on `a` alone, so that a restored run solves with the same bits. False: `a`
  // is not positive definite. The first factor of doubles allocates, nothing else does except an
  // error's message.
  bool factor(const BlockMatrix& a) {
    constexpr double kLeastPivot = 1e-4;
    in_floats_ = true;
    const bool good = static_cast<bool>(quick_.factor(a));
    if (std::abs(quick_.weakest_pivot()) > kLeastPivot) return good;
    if (!exact_) {
      Result<BlockCholesky> made = BlockCholesky::create(pattern_);
      if (!made) return good;
      exact_.emplace(std::move(*made));
      exact_->leave_out(out_);
    }
    in_floats_ = false;
    return static_cast<bool>(exact_->factor(a));
  }

  // Same as BlockFactor::leave_out().
  void leave_out(std::span<const std::uint8_t> out) {
    out_.assign(out.begin(), out.end());
    quick_.leave_out(out);
    if (exact_) exact_->leave_out(out);
  }

  // x <- near A^-1 x for the last factored matrix, linear in x.
  void solve(Eigen::VectorXd& x) {
    if (in_floats_)
      quick_.solve(x);
    else
      exact_->solve(x);
  }

  bool in_floats() const { return in_floats_; }

 private:
  QuickFactor(BlockPatternPointer pattern, BlockFactor<float> quick)
      : pattern_(std::move(pattern)), quick_(std::move(quick)), out_(pattern_->size(), 0) {}

  BlockPatternPointer pattern_;
  BlockFactor<float> quick_;
  std::optional<BlockCholesky> exact_;
  std::vector<std::uint8_t> out_;
  bool in_floats_ = true;  // the last factor
};

}  // namespace tremolo
