// Static displacement of the body under forces at chosen points, as far as the basis does not
// represent it (docs/theory.md, "What the basis lacks under a load"):
//
//     W = (K^-1 - U Lambda^-1 U^T) G        G: unit forces along x, y, z at each point
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "precompute/problem/precompute_request.h"
#include "precompute/problem/problem.h"
#include "precompute/reduction/rest_solve.h"

namespace tremolo {

// A point with a response: the vertex, or kAtDefaultLoad, and the control points with their
// fractions of a unit force there.
struct ResponsePlace {
  VertexId at = kAtDefaultLoad;
  std::vector<std::pair<VertexId, double>> shares;
};

// The requested points; that of the default load comes first. Ascending and unique. Throws Failure
// (kContent): no default load, a fixed vertex, more than kMaxResponsePlaces points.
std::vector<ResponsePlace> response_places(const Problem& problem,
                                           const LocalResponseRequest& request);

// K^-1 G: this rank's rows x 3 a place, m/N; of a free body, G self-balanced, on the complement of
// its rigid motions. residual: the largest |K X - G| / |G|. solver: prepared. Throws Failure as
// solve_at_rest. Collective.
struct RestResponse {
  Columns columns;
  double residual = 0;
};
RestResponse rest_response(const std::vector<ResponsePlace>& places, const LocalDofs& local,
                           const Pencil& pencil, const ShiftedSolver& solver);

// Subtracts U Lambda^-1 U^T G from the response at the part's vertices. rows: those of U there.
// Collective.
void remove_basis_share(const std::vector<ResponsePlace>& places, const LocalDofs& local,
                        const BasisRows& rows, const Eigen::VectorXd& lambda, BasisRows& response);

}  // namespace tremolo
