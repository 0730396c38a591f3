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

// A supernode while they are found. rows: below `end`. zeros: blocks of its columns that are.
struct Run {
  std::size_t begin = 0, end = 0;
  std::size_t zeros = 0;
  std::vector<Index> rows;

  std::size_t width() const { return end - begin; }
  std::size_t blocks() const { return width() * (width() + 1) / 2 + width() * rows.size(); }
};

// True if a run and its parent, the next run, should become one: dense blocks compensate for some
// zeros. The fractions are those of CHOLMOD for similar widths.
bool worth_joining(const Run& child, const Run& parent, std::size_t zeros) {
  constexpr std::array<std::pair<std::size_t, double>, 3> kShares = {
      {{4, 0.8}, {16, 0.15}, {48, 0.05}}};
  const std::size_t width = child.width() + parent.width();
  const std::size_t all = width * (width + 1) / 2 + width * parent.rows.size();
  for (const auto& [widest, share] : kShares)
    if (width <= widest) return static_cast<double>(zeros) <= share * static_cast<double>(all);
  return zeros == 0;
}

// Joins the last run with those before it whose parent it is, while that is worth it.
void join_last(std::vector<Run>& runs) {
  constexpr std::size_t kWidest = 96;  // nodes; wider ones do not fit into the second cache
  while (runs.size() > 1) {
    Run& child = runs[runs.size() - 2];
    Run& parent = runs.back();
    if (child.rows.empty() || child.rows.front() >= parent.end) return;
    if (child.width() + parent.width() > kWidest) return;
    const std::size_t more = parent.width() + parent.rows.size() - child.rows.size();
    const std::size_t zeros = child.zeros + parent.zeros + child.width() * more;
    if (!worth_joining(child, parent, zeros)) return;
    child.end = parent.end;
    child.zeros = zeros;
    child.rows = std::move(parent.rows);
    runs.pop_back();
  }
}

// The rows of each column below it are its own in the matrix and those of its children.
std::vector<Run> find_runs(const Lists& later, const std::vector<Index>& parent) {
  const std::size_t n = parent.size();
  std::vector<std::vector<Index>> rows(n);
  std::vector<std::vector<Index>> children(n);
  std::vector<Index> seen(n, kRoot);
  std::vector<Run> runs;
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
    runs.push_back({j, j + 1, 0, rows[j]});
    join_last(runs);
  }
  return runs;
}

}  // namespace

Elimination eliminate(const BlockPattern& pattern) {
  Elimination result;
  std::vector<Index> order = minimum_degree(pattern);
  const std::vector<Index> tree = elimination_tree(neighbours(pattern, inverse(order), false));
  for (const Index k : postorder(tree)) result.order.push_back(order[k]);
  const std::vector<Index> place = inverse(result.order);
  const Lists earlier = neighbours(pattern, place, false);
  const std::vector<Run> runs =
      find_runs(neighbours(pattern, place, true), elimination_tree(earlier));
  result.owner.resize(pattern.size());
  result.first.push_back(0);
  result.row_first.push_back(0);
  for (const Run& run : runs) {
    std::fill(result.owner.begin() + static_cast<std::ptrdiff_t>(run.begin),
              result.owner.begin() + static_cast<std::ptrdiff_t>(run.end),
              static_cast<Index>(result.first.size() - 1));
    result.first.push_back(static_cast<Index>(run.end));
    result.rows.insert(result.rows.end(), run.rows.begin(), run.rows.end());
    result.row_first.push_back(result.rows.size());
  }
  return result;
}

}  // namespace tremolo
