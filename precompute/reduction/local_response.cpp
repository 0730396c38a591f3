#include "precompute/reduction/local_response.h"

#include <algorithm>
#include <map>
#include <set>

#include "common/mesh/edge_points.h"
#include "common/text.h"
#include "formats/basis/basis_layout.h"
#include "formats/basis/selector_reader.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// Adds `share` of a unit force at a vertex: the displacement in an edge's middle is
// (c_a + 2 c_ab + c_b) / 4, so these are the weights of a force there.
void add_share(const TetMesh& mesh, VertexId vertex, double share,
               std::map<VertexId, double>& shares) {
  const MeshEdge* edge = edge_of_point(mesh, vertex);
  if (edge == nullptr) {
    shares[vertex] += share;
    return;
  }
  shares[edge->a] += 0.25 * share;
  shares[edge->b] += 0.25 * share;
  shares[vertex] += 0.5 * share;
}

ResponsePlace place_of(const TetMesh& mesh, VertexId vertex) {
  std::map<VertexId, double> shares;
  add_share(mesh, vertex, 1.0, shares);
  return {vertex, {shares.begin(), shares.end()}};
}

// All forces of the load point along their sum: a unit force is shared as the load is.
ResponsePlace place_of_load(const TetMesh& mesh, const DefaultLoad& load) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& force : load.forces) sum += force;
  std::map<VertexId, double> shares;
  for (std::size_t n = 0; n < load.vertices.size(); ++n)
    add_share(mesh, load.vertices[n], load.forces[n].dot(sum) / sum.squaredNorm(), shares);
  return {kAtDefaultLoad, {shares.begin(), shares.end()}};
}

std::set<VertexId> chosen_vertices(const Problem& problem, const Selector& selector) {
  std::set<VertexId> chosen;
  for (const VertexId vertex : unwrap(resolve_selector(selector, problem.mesh))) {
    if (std::binary_search(problem.fixed.begin(), problem.fixed.end(), vertex))
      throw Failure(content_error("--response-at " + selector.text + ": vertex " +
                                  std::to_string(vertex) + " is fixed, its displacement is zero"));
    chosen.insert(vertex);
  }
  if (chosen.empty())
    throw Failure(content_error("--response-at " + selector.text + " chooses no vertex"));
  return chosen;
}

// Calls use(row, weight) for each of the force's control points whose first row this rank owns.
// part: the point's number in the part.
template <class Use>
void for_own_rows(const ResponsePlace& place, const LocalDofs& local, const Use& use) {
  for (const auto& [vertex, weight] : place.shares) {
    const auto found = std::lower_bound(local.vertices.begin(), local.vertices.end(), vertex);
    if (found == local.vertices.end() || *found != vertex) continue;
    const auto part = found - local.vertices.begin();
    const int row = local.row_of_vertex[part];
    if (row >= 0) use(part, row, weight);
  }
}

}  // namespace

std::vector<ResponsePlace> response_places(const Problem& problem,
                                           const LocalResponseRequest& request) {
  const bool at_load = request.at_load;
  std::set<VertexId> vertices;
  for (const Selector& selector : request.at) vertices.merge(chosen_vertices(problem, selector));
  const std::size_t count = vertices.size() + (at_load ? 1 : 0);
  if (count > basis_layout::kMaxResponsePlaces)
    throw Failure(content_error(
        text("--response-at chooses %zu places; a file keeps the response at %d at most", count,
             static_cast<int>(basis_layout::kMaxResponsePlaces))));
  std::vector<ResponsePlace> places;
  if (at_load && problem.load.vertices.empty())
    throw Failure(content_error(
        "--response-at load: there is no default load; give --load-at and --load-force"));
  if (at_load) places.push_back(place_of_load(problem.mesh, problem.load));
  for (const VertexId vertex : vertices) places.push_back(place_of(problem.mesh, vertex));
  return places;
}

RestResponse rest_response(const std::vector<ResponsePlace>& places, const LocalDofs& local,
                           const Pencil& pencil, const ShiftedSolver& solver) {
  constexpr Eigen::Index kBlock = 8;  // columns that are solved for together
  RestResponse response;
  response.columns.resize(local.dofs(), 3 * std::ssize(places));
  const auto fill = [&](Eigen::Index first, Columns& loads) {
    for (Eigen::Index column = first; column < first + loads.cols(); ++column)
      for_own_rows(places[column / 3], local, [&](Eigen::Index, Eigen::Index row, double weight) {
        loads(row + column % 3, column - first) += weight;
      });
  };
  response.residual = solve_at_rest(pencil, solver, kBlock, fill, response.columns);
  return response;
}

void remove_basis_share(const std::vector<ResponsePlace>& places, const LocalDofs& local,
                        const BasisRows& rows, const Eigen::VectorXd& lambda, BasisRows& response) {
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(lambda.size(), 3 * std::ssize(places));  // U^T G
  for (std::size_t p = 0; p < places.size(); ++p)
    for_own_rows(places[p], local, [&](Eigen::Index part, Eigen::Index, double weight) {
      reduced.middleCols(3 * static_cast<Eigen::Index>(p), 3) +=
          weight * rows.middleRows(3 * part, 3).transpose();
    });
  sum_over_ranks(reduced);
  response.noalias() -= rows * (lambda.cwiseInverse().asDiagonal() * reduced);
}

}  // namespace tremolo
