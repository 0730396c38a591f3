#include "precompute/ranks/halo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tremolo {
namespace {

// Sections of one array, one for each rank.
struct Sections {
  std::vector<int> count, start;

  explicit Sections(std::vector<int> counts) : count(std::move(counts)) {
    start.resize(count.size(), 0);
    std::partial_sum(count.begin(), count.end() - 1, start.begin() + 1);
  }
  std::size_t total() const { return std::size_t{0} + start.back() + count.back(); }
};

// A communication plan. nodes: nodes of other ranks whose values this rank needs, ascending and
// therefore grouped by rank; requested: nodes whose values other ranks need from this one.
struct Exchange {
  std::vector<int> nodes;
  Sections received;
  std::vector<int> requested;
  Sections sent;
};

Exchange plan_exchange(const DofMap& map, const LocalDofs& local) {
  const std::size_t ranks = mpi_ranks();
  std::vector<int> nodes, received(ranks, 0), sent(ranks, 0);
  for (std::size_t v = 0; v < local.vertices.size(); ++v)
    if (local.node_of_vertex[v] >= 0 && local.row_of_vertex[v] < 0)
      nodes.push_back(local.node_of_vertex[v]);
  std::sort(nodes.begin(), nodes.end());
  std::size_t rank = 0;
  for (const int node : nodes) {
    while (node >= map.rank_begin[rank + 1]) ++rank;
    ++received[rank];
  }
  MPI_Alltoall(received.data(), 1, MPI_INT, sent.data(), 1, MPI_INT, PETSC_COMM_WORLD);
  Exchange exchange{std::move(nodes), Sections(received), {}, Sections(sent)};
  exchange.requested.resize(exchange.sent.total());
  MPI_Alltoallv(exchange.nodes.data(), exchange.received.count.data(),
                exchange.received.start.data(), MPI_INT, exchange.requested.data(),
                exchange.sent.count.data(), exchange.sent.start.data(), MPI_INT, PETSC_COMM_WORLD);
  return exchange;
}

// MPI type for the three rows of a node, contiguous.
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
  const Eigen::Index vertices = local.vertices.size();
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

  const Exchange exchange = plan_exchange(map, local);
  BasisRows out(3 * static_cast<Eigen::Index>(exchange.requested.size()), columns.cols());
  for (std::size_t i = 0; i < exchange.requested.size(); ++i)
    out.middleRows<3>(3 * static_cast<Eigen::Index>(i)) =
        columns.middleRows<3>(3 * Eigen::Index{exchange.requested[i] - local.first_node});
  BasisRows in(3 * static_cast<Eigen::Index>(exchange.nodes.size()), columns.cols());
  const RowType rows(columns.cols());
  MPI_Alltoallv(out.data(), exchange.sent.count.data(), exchange.sent.start.data(), rows.get(),
                in.data(), exchange.received.count.data(), exchange.received.start.data(),
                rows.get(), PETSC_COMM_WORLD);
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
  // Encodes the index of the entry in the whole mesh, doubled; odd if the entry is negative.
  std::vector<long long> first(count, std::numeric_limits<long long>::max() - 1);
  for (Eigen::Index c = 0; c < count; ++c) {
    Eigen::Index row = 0;
    while (row < expanded.rows() && std::abs(expanded(row, c)) < 0.5 * largest[c]) ++row;
    if (row == expanded.rows()) continue;
    const long long entry = 3LL * local.vertices[row / 3] + row % 3;
    first[c] = 2 * entry + (expanded(row, c) < 0 ? 1 : 0);
  }
  MPI_Allreduce(MPI_IN_PLACE, first.data(), static_cast<int>(count), MPI_LONG_LONG, MPI_MIN,
                PETSC_COMM_WORLD);
  for (Eigen::Index c = 0; c < count; ++c) {
    if (first[c] % 2 == 0) continue;
    // Subtraction avoids negative zeros, so that vectors expanded again have the same bits.
    expanded.col(c) = 0.0 - expanded.col(c).array();
    vectors.col(c) = 0.0 - vectors.col(c).array();
  }
}

}  // namespace tremolo
