#include "precompute/ranks/halo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tremolo {
namespace {

// For each rank a stretch of one list.
struct Stretches {
  std::vector<int> count, start;

  explicit Stretches(std::vector<int> counts) : count(std::move(counts)) {
    start.resize(count.size(), 0);
    std::partial_sum(count.begin(), count.end() - 1, start.begin() + 1);
  }
  std::size_t total() const {
    return static_cast<std::size_t>(start.back()) + static_cast<std::size_t>(count.back());
  }
};

// nodes: those of other ranks that this one wants, ascending, so that each rank's come together;
// asked: those that the others want of this one.
struct Exchange {
  std::vector<int> nodes;
  Stretches wanted;
  std::vector<int> asked;
  Stretches given;
};

Exchange agree(const DofMap& map, const LocalDofs& local) {
  const auto ranks = static_cast<std::size_t>(mpi_ranks());
  std::vector<int> nodes, wanted(ranks, 0), given(ranks, 0);
  for (std::size_t v = 0; v < local.vertices.size(); ++v)
    if (local.node_of_vertex[v] >= 0 && local.row_of_vertex[v] < 0)
      nodes.push_back(local.node_of_vertex[v]);
  std::sort(nodes.begin(), nodes.end());
  std::size_t rank = 0;
  for (const int node : nodes) {
    while (node >= map.rank_begin[rank + 1]) ++rank;
    ++wanted[rank];
  }
  MPI_Alltoall(wanted.data(), 1, MPI_INT, given.data(), 1, MPI_INT, PETSC_COMM_WORLD);
  Exchange exchange{std::move(nodes), Stretches(wanted), {}, Stretches(given)};
  exchange.asked.resize(exchange.given.total());
  MPI_Alltoallv(exchange.nodes.data(), exchange.wanted.count.data(), exchange.wanted.start.data(),
                MPI_INT, exchange.asked.data(), exchange.given.count.data(),
                exchange.given.start.data(), MPI_INT, PETSC_COMM_WORLD);
  return exchange;
}

// The three rows of a node, one after the other, as one message.
class RowType {
 public:
  explicit RowType(Eigen::Index columns) {
    MPI_Type_contiguous(static_cast<int>(3 * columns), MPI_DOUBLE, &type_);
    MPI_Type_commit(&type_);
  }
  ~RowType() { MPI_Type_free(&type_); }
  RowType(const RowType&) = delete;
  RowType& operator=(const RowType&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

}  // namespace

BasisRows expand_to_vertices(const DofMap& map, const LocalDofs& local, const Columns& columns) {
  const auto vertices = static_cast<Eigen::Index>(local.vertices.size());
  BasisRows expanded(3 * vertices, columns.cols());
  const auto at = [&](std::size_t v) {
    return expanded.middleRows<3>(3 * static_cast<Eigen::Index>(v));
  };
  for (std::size_t v = 0; v < local.vertices.size(); ++v) {
    if (local.row_of_vertex[v] >= 0)
      at(v) = columns.middleRows<3>(local.row_of_vertex[v]);
    else
      at(v).setZero();
  }
  if (mpi_ranks() == 1) return expanded;

  const Exchange exchange = agree(map, local);
  BasisRows out(3 * static_cast<Eigen::Index>(exchange.asked.size()), columns.cols());
  for (std::size_t i = 0; i < exchange.asked.size(); ++i)
    out.middleRows<3>(3 * static_cast<Eigen::Index>(i)) =
        columns.middleRows<3>(3 * Eigen::Index{exchange.asked[i] - local.first_node});
  BasisRows in(3 * static_cast<Eigen::Index>(exchange.nodes.size()), columns.cols());
  const RowType rows(columns.cols());
  MPI_Alltoallv(out.data(), exchange.given.count.data(), exchange.given.start.data(), rows.get(),
                in.data(), exchange.wanted.count.data(), exchange.wanted.start.data(), rows.get(),
                PETSC_COMM_WORLD);
  for (std::size_t v = 0; v < local.vertices.size(); ++v) {
    const int node = local.node_of_vertex[v];
    if (node < 0 || local.row_of_vertex[v] >= 0) continue;
    const auto found = std::lower_bound(exchange.nodes.begin(), exchange.nodes.end(), node);
    at(v) = in.middleRows<3>(3 * (found - exchange.nodes.begin()));
  }
  return expanded;
}

void fix_signs(const LocalDofs& local, Columns& vectors, BasisRows& expanded) {
  const Eigen::Index count = expanded.cols();
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(count);
  if (expanded.rows() > 0) largest = expanded.cwiseAbs().colwise().maxCoeff().transpose();
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(count), MPI_DOUBLE, MPI_MAX,
                PETSC_COMM_WORLD);
  // Where the entry is, in the whole mesh; odd: it is negative.
  std::vector<long long> first(static_cast<std::size_t>(count),
                               std::numeric_limits<long long>::max() - 1);
  for (Eigen::Index c = 0; c < count; ++c) {
    Eigen::Index row = 0;
    while (row < expanded.rows() && std::abs(expanded(row, c)) < 0.5 * largest[c]) ++row;
    if (row == expanded.rows()) continue;
    const long long place = 3LL * local.vertices[static_cast<std::size_t>(row / 3)] + row % 3;
    first[static_cast<std::size_t>(c)] = 2 * place + (expanded(row, c) < 0 ? 1 : 0);
  }
  MPI_Allreduce(MPI_IN_PLACE, first.data(), static_cast<int>(count), MPI_LONG_LONG, MPI_MIN,
                PETSC_COMM_WORLD);
  for (Eigen::Index c = 0; c < count; ++c) {
    if (first[static_cast<std::size_t>(c)] % 2 == 0) continue;
    // No zero becomes negative: vectors that are expanded again give the same bits.
    expanded.col(c) = 0.0 - expanded.col(c).array();
    vectors.col(c) = 0.0 - vectors.col(c).array();
  }
}

}  // namespace tremolo
