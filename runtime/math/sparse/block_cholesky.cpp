#include "runtime/math/sparse/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// C -= A B^T for matrices by columns. c: rows x columns, a: rows x depth, b: columns x depth; a may
// be read up to seven doubles behind its end.
struct PanelProduct {
  double* c;
  std::size_t c_stride;
  const double* a;
  std::size_t a_stride;
  const double* b;
  std::size_t b_stride;
  std::size_t rows, columns, depth;
};

constexpr std::uint32_t kNobody = static_cast<std::uint32_t>(-1);

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/sparse/panel.inc"
#include "runtime/math/kernels/every_instruction_set.inc"
#undef TREMOLO_KERNEL

namespace tremolo {

BlockCholesky::BlockCholesky(BlockPatternPointer pattern)
    : pattern_(std::move(pattern)), shape_(eliminate(*pattern_)) {}

Result<BlockCholesky> BlockCholesky::create(BlockPatternPointer pattern, std::size_t most_bytes) {
  BlockCholesky factor(std::move(pattern));
  const std::size_t n = factor.pattern_->size();
  const std::size_t entries = factor.count_panels();
  if (entries > most_bytes / sizeof(double))
    return system_error("a factor of " + std::to_string(entries / 131072) +
                        " MB is more than may be taken");
  factor.place_entries();
  factor.values_.assign(entries + kVectorLanes, 0.0);
  factor.local_.assign(n, 0);
  factor.waiting_.assign(factor.shape_.supernodes(), kNobody);
  factor.next_.assign(factor.shape_.supernodes(), kNobody);
  factor.done_.assign(factor.shape_.supernodes(), 0);
  factor.x_.assign(3 * n, 0.0);
  return factor;
}

// Sets the start of each panel, and the size of the largest product.
std::size_t BlockCholesky::count_panels() {
  std::size_t entries = 0, largest = 0, longest = 0;
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    panel_.push_back(entries);
    stride_.push_back(padded(height(s)));
    entries += stride_[s] * 3 * shape_.width(s);
    const std::size_t below = 3 * shape_.rows_below(s);
    const double rows = static_cast<double>(height(s)), width = static_cast<double>(below);
    multiplications_ += (rows * rows * rows - width * width * width) / 6.0;
    longest = std::max(longest, below);
    // One contribution goes to the rows of one other panel.
    std::size_t most = 0;
    for (std::size_t k = shape_.row_first[s]; k < shape_.row_first[s + 1];) {
      const std::size_t owner = shape_.owner[shape_.rows[k]], begin = k;
      while (k < shape_.row_first[s + 1] && shape_.owner[shape_.rows[k]] == owner) ++k;
      most = std::max(most, k - begin);
    }
    largest = std::max(largest, padded(below) * 3 * most);
  }
  update_.assign(largest + kVectorLanes, 0.0);
  below_.assign(longest + kVectorLanes, 0.0);
  return entries;
}

void BlockCholesky::place_entries() {
  const std::size_t n = pattern_->size();
  std::vector<std::uint32_t> place(n);
  for (std::size_t k = 0; k < n; ++k) place[shape_.order[k]] = static_cast<std::uint32_t>(k);
  const auto each = [&](auto&& act) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t p = pattern_->first()[i]; p < pattern_->first()[i + 1]; ++p) {
        const std::uint32_t row = place[i], column = place[pattern_->columns()[p]];
        act(std::min(row, column),
            Entry{std::max(row, column), static_cast<std::uint32_t>(p), row < column});
      }
  };
  entry_first_.assign(n + 1, 0);
  each([&](std::uint32_t column, const Entry&) { ++entry_first_[column + 1]; });
  for (std::size_t i = 0; i < n; ++i) entry_first_[i + 1] += entry_first_[i];
  entries_.resize(entry_first_[n]);
  std::vector<std::size_t> next(entry_first_.begin(), entry_first_.end() - 1);
  each([&](std::uint32_t column, const Entry& entry) { entries_[next[column]++] = entry; });
}

// Copies A's columns of supernode s, and sets the indices of its panel's rows.
void BlockCholesky::assemble(std::size_t s, const BlockMatrix& a) {
  const std::size_t begin = shape_.first[s], width = shape_.width(s), stride = stride_[s];
  double* panel = values_.data() + panel_[s];
  std::fill(panel, panel + stride * 3 * width, 0.0);
  for (std::size_t k = 0; k < width; ++k) local_[begin + k] = static_cast<std::uint32_t>(3 * k);
  const std::size_t rows = shape_.row_first[s];
  for (std::size_t k = 0; k < shape_.rows_below(s); ++k)
    local_[shape_.rows[rows + k]] = static_cast<std::uint32_t>(3 * (width + k));
  for (std::size_t j = begin; j < begin + width; ++j)
    for (std::size_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) {
      const Entry& entry = entries_[e];
      Eigen::Map<Eigen::Matrix3d, 0, Eigen::OuterStride<>> to(
          panel + 3 * (j - begin) * stride + local_[entry.row], Eigen::OuterStride<>(stride));
      if (entry.turned)
        to = a.block(entry.place).transpose();
      else
        to = a.block(entry.place);
    }
}

// Subtracts from panel s the contribution of an earlier supernode, whose rows from done_ on begin
// in s; that supernode then waits for the owner of its next row.
void BlockCholesky::subtract_from(std::size_t s, std::size_t descendant) {
  const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[descendant];
  const std::size_t all = shape_.rows_below(descendant), begin = done_[descendant];
  std::size_t end = begin;
  while (end < all && rows[end] < shape_.first[s + 1]) ++end;
  const std::size_t width = shape_.width(descendant), stride = stride_[descendant];
  const double* from = values_.data() + panel_[descendant] + 3 * (width + begin);
  const std::size_t height = 3 * (all - begin), columns = 3 * (end - begin);
  const std::size_t update_stride = padded(height);
  std::fill(update_.data(), update_.data() + update_stride * columns, 0.0);
  const PanelProduct product{update_.data(), update_stride, from,    stride,   from,
                             stride,         height,        columns, 3 * width};
  TREMOLO_CALL(subtract_product, product);
  for (std::size_t j = begin; j < end; ++j)
    for (std::size_t d = 0; d < 3; ++d) {
      double* to = values_.data() + panel_[s] + (3 * (rows[j] - shape_.first[s]) + d) * stride_[s];
      const double* column = update_.data() + (3 * (j - begin) + d) * update_stride;
      for (std::size_t i = j; i < all; ++i) {
        double* at = to + local_[rows[i]];
        const double* value = column + 3 * (i - begin);
        at[0] += value[0];
        at[1] += value[1];
        at[2] += value[2];
      }
    }
  done_[descendant] = end;
  wait_for_rows(descendant);
}

void BlockCholesky::wait_for_rows(std::size_t s) {
  if (done_[s] == shape_.rows_below(s)) return;
  const std::uint32_t owner = shape_.owner[shape_.rows[shape_.row_first[s] + done_[s]]];
  next_[s] = waiting_[owner];
  waiting_[owner] = static_cast<std::uint32_t>(s);
}

Status BlockCholesky::factor(const BlockMatrix& a) {
  std::fill(waiting_.begin(), waiting_.end(), kNobody);
  std::fill(done_.begin(), done_.end(), 0);
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    assemble(s, a);
    for (std::uint32_t k = waiting_[s]; k != kNobody;) {
      const std::uint32_t after = next_[k];
      subtract_from(s, k);
      k = after;
    }
    const std::size_t columns = 3 * shape_.width(s);
    const std::size_t good =
        TREMOLO_CALL(factor_panel, values_.data() + panel_[s], stride_[s], height(s), columns);
    if (good < columns)
      return Error{ErrorKind::kSolver,
                   "the matrix is not positive definite: the pivot of node " +
                       std::to_string(shape_.order[shape_.first[s] + good / 3]) +
                       " is not a positive number"};
    wait_for_rows(s);
  }
  return Success{};
}

void BlockCholesky::solve(Eigen::VectorXd& x) {
  for (std::size_t k = 0; k < shape_.order.size(); ++k)
    std::copy_n(x.data() + 3 * std::size_t{shape_.order[k]}, 3, x_.data() + 3 * k);
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[s];
    const std::size_t count = shape_.rows_below(s);
    std::fill_n(below_.begin(), 3 * count, 0.0);
    TREMOLO_CALL(solve_forward, values_.data() + panel_[s], stride_[s], height(s),
                 3 * shape_.width(s), x_.data() + 3 * std::size_t{shape_.first[s]}, below_.data());
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t d = 0; d < 3; ++d) x_[3 * std::size_t{rows[k]} + d] += below_[3 * k + d];
  }
  for (std::size_t s = shape_.supernodes(); s-- > 0;) {
    const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[s];
    const std::size_t count = shape_.rows_below(s);
    for (std::size_t k = 0; k < count; ++k)
      std::copy_n(x_.data() + 3 * std::size_t{rows[k]}, 3, below_.data() + 3 * k);
    TREMOLO_CALL(solve_backward, values_.data() + panel_[s], stride_[s], height(s),
                 3 * shape_.width(s), x_.data() + 3 * std::size_t{shape_.first[s]}, below_.data());
  }
  for (std::size_t k = 0; k < shape_.order.size(); ++k)
    std::copy_n(x_.data() + 3 * k, 3, x.data() + 3 * std::size_t{shape_.order[k]});
}

}  // namespace tremolo
