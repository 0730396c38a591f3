// A = L L^T of a sparse symmetric positive definite matrix of 3 x 3 blocks, and A^-1 b.
//
// The factor consists of dense panels, one for each supernode. From its columns J the contributions
// of the columns to the left are subtracted, A_J - sum_K L_K L_K(J)^T, as products of dense
// matrices; then the panel is factored (Ng and Peyton 1993, left-looking).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

// The order in which a sparse symmetric matrix is eliminated, and the columns of its factor that
// have the same rows. Both follow from the pattern alone and are computed once.

// The elimination. Nodes are renumbered in its order. A supernode is a run of nodes whose columns
// of the factor have the same rows below it (some of them zeros, where that makes longer runs).
struct Elimination {
  std::vector<std::uint32_t> order;    // the old number of each node
  std::vector<std::uint32_t> first;    // start of each supernode; supernodes() + 1 entries
  std::vector<std::size_t> row_first;  // start of each supernode's rows; supernodes() + 1 entries
  std::vector<std::uint32_t> rows;     // below each supernode, ascending
  std::vector<std::uint32_t> owner;    // the supernode of each node
  std::vector<std::size_t> zeros;      // blocks of each supernode that are zeros, about

  static constexpr std::uint32_t kNoPlace = static_cast<std::uint32_t>(-1);

  std::size_t supernodes() const { return first.size() - 1; }
  std::size_t width(std::size_t s) const { return first[s + 1] - first[s]; }
  std::size_t rows_below(std::size_t s) const { return row_first[s + 1] - row_first[s]; }
};

// Eigen's approximate minimum degree (Amestoy, Davis and Duff 1996), then the elimination tree (Liu
// 1990) in postorder.
Elimination eliminate(const BlockPattern& pattern);

// The same without the nodes whose flag is not 0. place: receives the new number of each node of
// `all`, or kNoPlace. Nothing is allocated if both results have been as large as `all`.
void leave_out(const Elimination& all, std::span<const std::uint8_t> out,
               std::vector<std::uint32_t>& place, Elimination& rest);

// The factor's entries are doubles or floats; a float one takes half of the memory and time and
// leaves errors of 1e-7 times the matrix's condition, as what preconditions a solve may.
template <class Scalar>
class BlockFactor {
 public:
  // Finds the order and the nonzero entries of the factor, and allocates all memory. Error
  // (kSystem): a factor of more than `most_bytes`.
  static Result<BlockFactor> create(BlockPatternPointer pattern,
                                    std::size_t most_bytes = std::size_t{8} << 30);

  // The factor's bytes, and the multiplications of a factorisation.
  std::size_t bytes() const { return entries_of_panels_ * sizeof(Scalar); }
  double multiplications() const { return multiplications_; }

  // Leaves out the nodes whose flag is not 0, one flag per node, until the next call: their rows
  // and columns of A are never read, and solve() leaves their entries as they are. A factor without
  // them is smaller. There is none until the next factor(). Nothing is allocated, unless joined
  // supernodes need more than they did with all nodes.
  void leave_out(std::span<const std::uint8_t> out);

  // a: of the pattern. Error kSolver, naming the node: a pivot is not positive or not finite; there
  // is no factor then. Nothing is allocated except an error's message.
  Status factor(const BlockMatrix& a);

  // The smallest pivot of the last factor() as a fraction of A's diagonal there: rounding is that
  // much larger in the factor than in A. The first one that is not positive, where there is one.
  double weakest_pivot() const { return weakest_; }

  // x <- A^-1 x for the last factored matrix; 3 size() long. Nothing is allocated.
  void solve(Eigen::VectorXd& x);

 private:
  // An entry of A in the columns of the factor.
  struct Entry {
    std::uint32_t row = 0;
    std::uint32_t place = 0;
    bool turned = false;  // its transpose is stored
  };

  explicit BlockFactor(BlockPatternPointer pattern);
  void place_entries();
  std::size_t count_panels();
  void place_panels();
  std::size_t height(std::size_t s) const { return 3 * (shape_.width(s) + shape_.rows_below(s)); }
  void assemble(std::size_t s, const BlockMatrix& a);
  void subtract_from(std::size_t s, std::size_t descendant);
  void wait_for_rows(std::size_t s);

  BlockPatternPointer pattern_;
  Elimination all_, shape_;  // of all nodes; of those that are not left out
  std::vector<std::uint8_t> out_;
  std::vector<std::uint32_t> place_, number_;          // number_: in shape_ by node, or kNoPlace
  std::vector<std::size_t> entry_first_, next_entry_;  // by columns
  std::vector<Entry> entries_;
  std::vector<std::size_t> panel_;   // start of each panel in values_
  std::vector<std::size_t> stride_;  // between its columns
  std::vector<Scalar, CacheLineAllocator<Scalar>> values_;
  std::vector<Scalar, CacheLineAllocator<Scalar>> update_;  // the present product
  std::vector<std::uint32_t> local_;           // of the present panel: index of a node's row
  std::vector<std::uint32_t> waiting_, next_;  // supernodes that a panel still needs, as lists
  std::vector<std::size_t> done_;    // number of its rows that a supernode has contributed
  std::vector<Scalar> x_, local_x_;  // local_x_: of a panel's rows
  std::vector<Scalar> diagonal_;     // of A
  std::size_t entries_of_panels_ = 0;
  double multiplications_ = 0.0, weakest_ = 1.0;
};

extern template class BlockFactor<double>;
extern template class BlockFactor<float>;
using BlockCholesky = BlockFactor<double>;

}  // namespace tremolo
