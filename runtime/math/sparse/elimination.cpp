#include <algorithm>
#include <array>
#include <utility>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "runtime/math/sparse/block_cholesky.h"

namespace tremolo {
namespace {

using Index = std::uint32_t;
constexpr Index kRoot = static_cast<Index>(-1);
constexpr Index kNoPlace = Elimination::kNoPlace;

// Rows of a graph, one after another.
struct Lists {
  std::vector<std::size_t> first;
  std::vector<Index> entries;
};

// Lists each node's neighbours that come later in the new order, or earlier.
Lists neighbours(const BlockPattern& pattern, const std::vector<Index>& place, bool later) {
  const std::size_t n = pattern.size();
  Lists lists{std::vector<std::size_t>(n + 1, 0), {}};
  const auto each_pair = [&](auto&& act) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t p = pattern.first()[i]; p + 1 < pattern.first()[i + 1]; ++p) {
        const auto [low, high] = std::minmax(place[i], place[pattern.columns()[p]]);
        later ? act(low, high) : act(high, low);
      }
  };
  each_pair([&](Index of, Index) { ++lists.first[of + 1]; });
  for (std::size_t i = 0; i < n; ++i) lists.first[i + 1] += lists.first[i];
  lists.entries.resize(lists.first[n]);
  std::vector<std::size_t> next(lists.first.begin(), lists.first.end() - 1);
  each_pair([&](Index of, Index other) { lists.entries[next[of]++] = other; });
  return lists;
}

std::vector<Index> minimum_degree(const BlockPattern& pattern) {
  const std::size_t n = pattern.size();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(pattern.blocks());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t p = pattern.first()[i]; p < pattern.first()[i + 1]; ++p)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(pattern.columns()[p]), 1.0);
  Eigen::SparseMatrix<double> graph(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  std::vector<Index> order(n);
  for (std::size_t k = 0; k < n; ++k) order[k] = static_cast<Index>(permutation.indices()[k]);
  return order;
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<Index>(k);
  return place;
}

std::vector<Index> elimination_tree(const Lists& earlier) {
  const std::size_t n = earlier.first.size() - 1;
  std::vector<Index> parent(n, kRoot), ancestor(n, kRoot);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t p = earlier.first[i]; p < earlier.first[i + 1]; ++p)
      for (Index k = earlier.entries[p]; k != kRoot && k != i;) {
        const Index next = ancestor[k];
        ancestor[k] = static_cast<Index>(i);
        if (next == kRoot) parent[k] = static_cast<Index>(i);
        k = next;
      }
  return parent;
}

// The old number of each place.
std::vector<Index> postorder(const std::vector<Index>& parent) {
  const std::size_t n = parent.size();
  std::vector<Index> child(n, kRoot), sibling(n, kRoot), stack, order;
  for (std::size_t k = n; k-- > 0;)
    if (parent[k] != kRoot) sibling[k] = std::exchange(child[parent[k]], static_cast<Index>(k));
  order.reserve(n);
  for (std::size_t root = 0; root < n; ++root) {
    if (parent[root] != kRoot) continue;
    stack.push_back(static_cast<Index>(root));
    while (!stack.empty()) {
      const Index k = stack.back();
      if (child[k] != kRoot) {
        stack.push_back(std::exchange(child[k], kRoot));
        continue;
      }
      stack.pop_back();
      order.push_back(k);
      if (sibling[k] != kRoot) stack.push_back(sibling[k]);
    }
  }
  return order;
}

// Blocks of a run of columns with these rows below it.
std::size_t blocks_of(std::size_t width, std::size_t rows) {
  return width * (width + 1) / 2 + width * rows;
}

// True if a run and its parent, the next run, should become one: dense blocks compensate for some
// zeros. The fractions are those of CHOLMOD for similar widths.
bool worth_joining(std::size_t width, std::size_t rows, std::size_t zeros) {
  constexpr std::array<std::pair<std::size_t, double>, 3> kShares = {
      {{4, 0.8}, {16, 0.15}, {48, 0.05}}};
  for (const auto& [widest, share] : kShares)
    if (width <= widest)
      return static_cast<double>(zeros) <= share * static_cast<double>(blocks_of(width, rows));
  return zeros == 0;
}

// Joins the last run with those before it whose parent it is, while that is worth it.
void join_last(Elimination& shape) {
  constexpr std::size_t kWidest = 96;  // nodes; wider ones do not fit into the second cache
  while (shape.supernodes() > 1) {
    const std::size_t parent = shape.supernodes() - 1, child = parent - 1;
    const std::size_t own = shape.rows_below(child), rows = shape.rows_below(parent);
    if (own == 0 || shape.rows[shape.row_first[child]] >= shape.first[parent + 1]) return;
    const std::size_t width = shape.width(child) + shape.width(parent);
    if (width > kWidest) return;
    const std::size_t more = shape.width(child) * (shape.width(parent) + rows - own);
    const std::size_t zeros = shape.zeros[child] + shape.zeros[parent] + more;
    if (!worth_joining(width, rows, zeros)) return;
    const auto begin = shape.rows.begin() + static_cast<std::ptrdiff_t>(shape.row_first[child]);
    shape.rows.erase(begin, begin + static_cast<std::ptrdiff_t>(own));
    shape.row_first[parent] = shape.rows.size();
    shape.row_first.pop_back();
    shape.first[parent] = shape.first[parent + 1];
    shape.first.pop_back();
    shape.zeros[child] = zeros;
    shape.zeros.pop_back();
  }
}

void clear(Elimination& shape) {
  shape.order.clear();
  shape.first.assign(1, 0);
  shape.row_first.assign(1, 0);
  shape.zeros.clear();
  shape.rows.clear();
}

// Ends a run before column `end`; its rows have been appended.
void end_run(Elimination& shape, std::size_t end, std::size_t zeros) {
  shape.first.push_back(static_cast<Index>(end));
  shape.row_first.push_back(shape.rows.size());
  shape.zeros.push_back(zeros);
  join_last(shape);
}

void find_owners(Elimination& shape) {
  shape.owner.resize(shape.order.size());
  for (std::size_t s = 0; s < shape.supernodes(); ++s)
    std::fill(shape.owner.begin() + shape.first[s], shape.owner.begin() + shape.first[s + 1],
              static_cast<Index>(s));
}

// The rows of each column below it are its own in the matrix and those of its children.
void find_runs(const Lists& later, const std::vector<Index>& parent, Elimination& shape) {
  const std::size_t n = parent.size();
  std::vector<std::vector<Index>> rows(n);
  std::vector<std::vector<Index>> children(n);
  std::vector<Index> seen(n, kRoot);
  for (std::size_t j = 0; j < n; ++j) {
    const auto add = [&](Index row) {
      if (row == j || seen[row] == j) return;
      seen[row] = static_cast<Index>(j);
      rows[j].push_back(row);
    };
    for (std::size_t p = later.first[j]; p < later.first[j + 1]; ++p) add(later.entries[p]);
    for (const Index child : children[j]) {
      for (const Index row : rows[child]) add(row);
      rows[child] = {};
    }
    std::sort(rows[j].begin(), rows[j].end());
    if (parent[j] != kRoot) children[parent[j]].push_back(static_cast<Index>(j));
    shape.rows.insert(shape.rows.end(), rows[j].begin(), rows[j].end());
    end_run(shape, j + 1, 0);
  }
}

}  // namespace

Elimination eliminate(const BlockPattern& pattern) {
  Elimination result;
  clear(result);
  std::vector<Index> order = minimum_degree(pattern);
  const std::vector<Index> tree = elimination_tree(neighbours(pattern, inverse(order), false));
  for (const Index k : postorder(tree)) result.order.push_back(order[k]);
  const std::vector<Index> place = inverse(result.order);
  const Lists earlier = neighbours(pattern, place, false);
  find_runs(neighbours(pattern, place, true), elimination_tree(earlier), result);
  find_owners(result);
  return result;
}

void leave_out(const Elimination& all, std::span<const std::uint8_t> out,
               std::vector<std::uint32_t>& place, Elimination& rest) {
  clear(rest);
  for (std::size_t k = 0; k < all.order.size(); ++k) {
    place[k] = out[all.order[k]] != 0 ? kNoPlace : static_cast<Index>(rest.order.size());
    if (place[k] != kNoPlace) rest.order.push_back(all.order[k]);
  }
  std::size_t column = 0;
  for (std::size_t s = 0; s < all.supernodes(); ++s) {
    const std::size_t begin = column, before = rest.rows.size();
    for (std::size_t k = all.first[s]; k < all.first[s + 1]; ++k)
      if (place[k] != kNoPlace) ++column;
    if (column == begin) continue;
    for (std::size_t k = all.row_first[s]; k < all.row_first[s + 1]; ++k)
      if (place[all.rows[k]] != kNoPlace) rest.rows.push_back(place[all.rows[k]]);
    const std::size_t blocks = blocks_of(column - begin, rest.rows.size() - before);
    end_run(rest, column, all.zeros[s] * blocks / blocks_of(all.width(s), all.rows_below(s)));
  }
  find_owners(rest);
}

}  // namespace tremolo
