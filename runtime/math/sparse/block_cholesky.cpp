#include "runtime/math/sparse/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// C -= A B^T for matrices by columns. c: rows x columns, a: rows x depth, b: columns x depth; a may
// be read up to a vector behind its end.
template <class Scalar>
struct PanelProduct {
  Scalar* c;
  std::size_t c_stride;
  const Scalar* a;
  std::size_t a_stride;
  const Scalar* b;
  std::size_t b_stride;
  std::size_t rows, columns, depth;
};

// Entries in a vector of 64 bytes, to which columns are padded.
template <class Scalar>
constexpr std::size_t kInVector = 64 / sizeof(Scalar);

template <class Scalar>
std::size_t padded_to_vectors(std::size_t count) {
  return (count + kInVector<Scalar> - 1) / kInVector<Scalar> * kInVector<Scalar>;
}

constexpr std::uint32_t kNobody = static_cast<std::uint32_t>(-1);

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/sparse/panel.inc"
#include "runtime/math/kernels/every_instruction_set.inc"
#undef TREMOLO_KERNEL

namespace tremolo {

template <class Scalar>
BlockFactor<Scalar>::BlockFactor(BlockPatternPointer pattern)
    : pattern_(std::move(pattern)), all_(eliminate(*pattern_)), shape_(all_) {
  const std::size_t n = pattern_->size();
  out_.assign(n, 0);
  place_.resize(n);
  number_.resize(n);
  for (std::size_t k = 0; k < n; ++k) number_[shape_.order[k]] = static_cast<std::uint32_t>(k);
}

template <class Scalar>
Result<BlockFactor<Scalar>> BlockFactor<Scalar>::create(BlockPatternPointer pattern,
                                                        std::size_t most_bytes) {
  BlockFactor factor(std::move(pattern));
  const std::size_t n = factor.pattern_->size();
  const std::size_t entries = factor.count_panels();
  if (entries > most_bytes / sizeof(Scalar))
    return system_error("a factor of " + std::to_string(entries * sizeof(Scalar) >> 20) +
                        " MB is more than may be taken");
  factor.place_entries();
  factor.place_panels();
  factor.local_.assign(n, 0);
  factor.waiting_.assign(factor.shape_.supernodes(), kNobody);
  factor.next_.assign(factor.shape_.supernodes(), kNobody);
  factor.done_.assign(factor.shape_.supernodes(), 0);
  factor.x_.assign(3 * n, Scalar{});
  factor.diagonal_.assign(3 * n, Scalar{});
  return factor;
}

template <class Scalar>
void BlockFactor<Scalar>::leave_out(std::span<const std::uint8_t> out) {
  if (std::equal(out.begin(), out.end(), out_.begin())) return;
  std::copy(out.begin(), out.end(), out_.begin());
  tremolo::leave_out(all_, out, place_, shape_);
  for (std::size_t k = 0; k < all_.order.size(); ++k) number_[all_.order[k]] = place_[k];
  count_panels();
  place_entries();
  place_panels();
}

// Sets the start of each panel. Returns the number of all entries.
template <class Scalar>
std::size_t BlockFactor<Scalar>::count_panels() {
  std::size_t entries = 0;
  panel_.clear();
  stride_.clear();
  multiplications_ = 0.0;
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    panel_.push_back(entries);
    stride_.push_back(padded_to_vectors<Scalar>(height(s)));
    entries += stride_[s] * 3 * shape_.width(s);
    const std::size_t below = 3 * shape_.rows_below(s);
    const double rows = static_cast<double>(height(s)), width = static_cast<double>(below);
    multiplications_ += (rows * rows * rows - width * width * width) / 6.0;
  }
  entries_of_panels_ = entries;
  return entries;
}

// Finds the size of the largest product, and makes place for that and for all panels.
template <class Scalar>
void BlockFactor<Scalar>::place_panels() {
  std::size_t largest = 0, longest = 0;
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    longest = std::max(longest, height(s));
    // One contribution goes to the rows of one other panel.
    std::size_t most = 0;
    for (std::size_t k = shape_.row_first[s]; k < shape_.row_first[s + 1];) {
      const std::size_t owner = shape_.owner[shape_.rows[k]], begin = k;
      while (k < shape_.row_first[s + 1] && shape_.owner[shape_.rows[k]] == owner) ++k;
      most = std::max(most, k - begin);
    }
    largest = std::max(largest, padded_to_vectors<Scalar>(3 * shape_.rows_below(s)) * 3 * most);
  }
  const auto grow = [](auto& list, std::size_t size) {
    if (list.size() < size + kInVector<Scalar>) list.resize(size + kInVector<Scalar>);
  };
  grow(update_, largest);
  grow(local_x_, longest);
  grow(values_, entries_of_panels_);
}

template <class Scalar>
void BlockFactor<Scalar>::place_entries() {
  const std::size_t n = shape_.order.size();
  const auto each = [&](auto&& act) {
    for (std::size_t i = 0; i < pattern_->size(); ++i) {
      if (out_[i] != 0) continue;
      for (std::size_t p = pattern_->first()[i]; p < pattern_->first()[i + 1]; ++p) {
        if (out_[pattern_->columns()[p]] != 0) continue;
        const std::uint32_t row = number_[i], column = number_[pattern_->columns()[p]];
        act(std::min(row, column),
            Entry{std::max(row, column), static_cast<std::uint32_t>(p), row < column});
      }
    }
  };
  entry_first_.assign(n + 1, 0);
  each([&](std::uint32_t column, const Entry&) { ++entry_first_[column + 1]; });
  for (std::size_t i = 0; i < n; ++i) entry_first_[i + 1] += entry_first_[i];
  entries_.resize(entry_first_[n]);
  next_entry_.assign(entry_first_.begin(), entry_first_.end() - 1);
  each([&](std::uint32_t column, const Entry& entry) { entries_[next_entry_[column]++] = entry; });
}

// Copies A's columns of supernode s, and sets the indices of its panel's rows.
template <class Scalar>
void BlockFactor<Scalar>::assemble(std::size_t s, const BlockMatrix& a) {
  const std::size_t begin = shape_.first[s], width = shape_.width(s), stride = stride_[s];
  Scalar* panel = values_.data() + panel_[s];
  std::fill(panel, panel + stride * 3 * width, Scalar{});
  for (std::size_t k = 0; k < width; ++k) local_[begin + k] = static_cast<std::uint32_t>(3 * k);
  const std::size_t rows = shape_.row_first[s];
  for (std::size_t k = 0; k < shape_.rows_below(s); ++k)
    local_[shape_.rows[rows + k]] = static_cast<std::uint32_t>(3 * (width + k));
  for (std::size_t j = begin; j < begin + width; ++j)
    for (std::size_t e = entry_first_[j]; e < entry_first_[j + 1]; ++e) {
      const Entry& entry = entries_[e];
      Eigen::Map<Eigen::Matrix<Scalar, 3, 3>, 0, Eigen::OuterStride<>> to(
          panel + 3 * (j - begin) * stride + local_[entry.row], Eigen::OuterStride<>(stride));
      if (entry.turned)
        to = a.block(entry.place).transpose().template cast<Scalar>();
      else
        to = a.block(entry.place).template cast<Scalar>();
    }
}

// Subtracts from panel s the contribution of an earlier supernode, whose rows from done_ on begin
// in s; that supernode then waits for the owner of its next row.
template <class Scalar>
void BlockFactor<Scalar>::subtract_from(std::size_t s, std::size_t descendant) {
  const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[descendant];
  const std::size_t all = shape_.rows_below(descendant), begin = done_[descendant];
  std::size_t end = begin;
  while (end < all && rows[end] < shape_.first[s + 1]) ++end;
  const std::size_t width = shape_.width(descendant), stride = stride_[descendant];
  const Scalar* from = values_.data() + panel_[descendant] + 3 * (width + begin);
  const std::size_t height = 3 * (all - begin), columns = 3 * (end - begin);
  const std::size_t update_stride = padded_to_vectors<Scalar>(height);
  std::fill(update_.data(), update_.data() + update_stride * columns, Scalar{});
  const PanelProduct<Scalar> product{update_.data(), update_stride, from,    stride,   from,
                                     stride,         height,        columns, 3 * width};
  TREMOLO_CALL(subtract_product<Scalar>, product);
  for (std::size_t j = begin; j < end; ++j)
    for (std::size_t d = 0; d < 3; ++d) {
      Scalar* to = values_.data() + panel_[s] + (3 * (rows[j] - shape_.first[s]) + d) * stride_[s];
      const Scalar* column = update_.data() + (3 * (j - begin) + d) * update_stride;
      for (std::size_t i = j; i < all; ++i) {
        Scalar* at = to + local_[rows[i]];
        const Scalar* value = column + 3 * (i - begin);
        at[0] += value[0];
        at[1] += value[1];
        at[2] += value[2];
      }
    }
  done_[descendant] = end;
  wait_for_rows(descendant);
}

template <class Scalar>
void BlockFactor<Scalar>::wait_for_rows(std::size_t s) {
  if (done_[s] == shape_.rows_below(s)) return;
  const std::uint32_t owner = shape_.owner[shape_.rows[shape_.row_first[s] + done_[s]]];
  next_[s] = waiting_[owner];
  waiting_[owner] = static_cast<std::uint32_t>(s);
}

template <class Scalar>
Status BlockFactor<Scalar>::factor(const BlockMatrix& a) {
  std::fill(waiting_.begin(), waiting_.end(), kNobody);
  std::fill(done_.begin(), done_.end(), 0);
  weakest_ = 1.0;
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    assemble(s, a);
    const Scalar* panel = values_.data() + panel_[s];
    Scalar* given = diagonal_.data() + 3 * std::size_t{shape_.first[s]};
    for (std::size_t j = 0; j < 3 * shape_.width(s); ++j) given[j] = panel[j * stride_[s] + j];
    for (std::uint32_t k = waiting_[s]; k != kNobody;) {
      const std::uint32_t after = next_[k];
      subtract_from(s, k);
      k = after;
    }
    const std::size_t columns = 3 * shape_.width(s);
    const std::size_t good = TREMOLO_CALL(factor_panel<Scalar>, values_.data() + panel_[s],
                                          stride_[s], height(s), columns);
    for (std::size_t j = 0; j < good; ++j)
      weakest_ = std::min(weakest_, static_cast<double>(panel[j * stride_[s] + j] *
                                                        panel[j * stride_[s] + j] / given[j]));
    if (good < columns) weakest_ = panel[good * stride_[s] + good] / given[good];
    if (good < columns)
      return Error{ErrorKind::kSolver,
                   "the matrix is not positive definite: the pivot of node " +
                       std::to_string(shape_.order[shape_.first[s] + good / 3]) +
                       " is not a positive number"};
    wait_for_rows(s);
  }
  return Success{};
}

template <class Scalar>
void BlockFactor<Scalar>::solve(Eigen::VectorXd& x) {
  for (std::size_t k = 0; k < shape_.order.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d)
      x_[3 * k + d] = static_cast<Scalar>(x.data()[3 * std::size_t{shape_.order[k]} + d]);
  for (std::size_t s = 0; s < shape_.supernodes(); ++s) {
    const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[s];
    const std::size_t count = shape_.rows_below(s), width = 3 * shape_.width(s);
    Scalar* own = x_.data() + 3 * std::size_t{shape_.first[s]};
    Scalar* below = local_x_.data() + width;
    std::copy_n(own, width, local_x_.data());
    std::fill_n(below, 3 * count + kInVector<Scalar>, Scalar{});
    TREMOLO_CALL(solve_forward<Scalar>, values_.data() + panel_[s], stride_[s], height(s), width,
                 local_x_.data());
    std::copy_n(local_x_.data(), width, own);
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t d = 0; d < 3; ++d) x_[3 * std::size_t{rows[k]} + d] += below[3 * k + d];
  }
  for (std::size_t s = shape_.supernodes(); s-- > 0;) {
    const std::uint32_t* rows = shape_.rows.data() + shape_.row_first[s];
    const std::size_t count = shape_.rows_below(s), width = 3 * shape_.width(s);
    Scalar* own = x_.data() + 3 * std::size_t{shape_.first[s]};
    Scalar* below = local_x_.data() + width;
    std::copy_n(own, width, local_x_.data());
    for (std::size_t k = 0; k < count; ++k)
      std::copy_n(x_.data() + 3 * std::size_t{rows[k]}, 3, below + 3 * k);
    std::fill_n(below + 3 * count, kInVector<Scalar>, Scalar{});
    TREMOLO_CALL(solve_backward<Scalar>, values_.data() + panel_[s], stride_[s], height(s), width,
                 local_x_.data());
    std::copy_n(local_x_.data(), width, own);
  }
  for (std::size_t k = 0; k < shape_.order.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d)
      x.data()[3 * std::size_t{shape_.order[k]} + d] = x_[3 * k + d];
}

template class BlockFactor<double>;
template class BlockFactor<float>;

}  // namespace tremolo
