// Comparison of a reduced model with the full-order body of the same mesh.
#pragma once

#include <limits>
#include <optional>

#include "formats/basis/basis_data.h"
#include "precompute/reference/full/full_order_solver.h"
#include "precompute/reference/reduced_model.h"

namespace tremolo {

// basis: N x r on the body's unknowns; mass_basis: M * basis.
struct ReducedBody {
  ReducedModel model;
  Eigen::MatrixXd basis, mass_basis;
};

// basis: N x r on the body's unknowns.
ReducedBody make_reduced_body(const FullOrder& body, ReducedModel model, Eigen::MatrixXd basis);

// Makes the reduced body from the first `modes` coordinates of the data (default: all). mesh_hash:
// must equal the hash in the data's provenance. name: of the file, for messages. Throws Failure
// (kContent) for another mesh, other held vertices, or a basis for which U^T M U or U^T K U differs
// by more than 1e-6 (2 % for a compact file), which means that it was made with other materials.
ReducedBody make_reduced_body(const FullOrder& body, const BasisData& data,
                              const std::string& mesh_hash, std::optional<int> modes,
                              const std::string& name);

// Comparison at one instant. u: displacement of the body; |.|: the M norm, kg^1/2 m.
struct Moment {
  double norm = 0;                  // |u|
  double difference = 0;            // |u - U q|
  double projection = 0;            // |u - U U^T M u|: lower bound over all q
  double mac = 0;                   // (u . Uq)^2 / (|u|^2 |Uq|^2), . by M; 1: same shape
  double tip = 0;                   // largest displacement of the watched vertices, m
  double tip_difference = 0;        // largest distance between both there, m
  double energy_difference = 0;     // reduced minus full total energy, J
  double shown_difference = 0;      // |u - U q - W f|: with the response to the load's force f
  double shown_tip_difference = 0;  // m, with that response
};
// mass_u: M u.
Moment compare(const FullOrder& body, const ReducedBody& reduced, const Vector& u,
               const Vector& mass_u, const Vector& q, const std::vector<VertexId>& watched);

// Adds to `moment` how far u is from U q + W f. response: W f.
void compare_shown(const FullOrder& body, const ReducedBody& reduced, const Vector& u,
                   const Vector& q, const Vector& response, const std::vector<VertexId>& watched,
                   Moment& moment);

// The largest value of each measure over time, dimensionless except for energy. *_of_largest:
// differences relative to the largest |u| (or tip) of all instants. *_at_once: relative to |u| at
// the same instant, for instants with at least a tenth of the largest. NaN: not measured, because
// nothing moved or no vertex is watched.
struct ComparisonSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double error_of_largest = kNone;
  double error_at_once = kNone;
  double projection_of_largest = kNone;
  double projection_at_once = kNone;
  double tip_error_of_largest = kNone;
  double mac_least = kNone;  // over the same instants
  double energy_difference = kNone;
  double shown_of_largest = kNone;
  double shown_tip_of_largest = kNone;
};
ComparisonSummary summarise(const std::vector<Moment>& moments);

// Returns what the basis lacks of the body's linear answer to the load (docs/theory.md), K^-1 f -
// U Lambda^-1 U^T f. response: K^-1 f.
Vector response_beyond(const ReducedBody& reduced, const Vector& load, const Vector& response);

// Returns 1 - f^T U Lambda^-1 U^T f / f^T K^-1 f: the part of the load's linear compliance (twice
// the elastic energy it stores in the linear body) that the basis cannot represent. 0: the linear
// response lies in the basis; NaN for a zero load. response: K^-1 f (see linear_response()); for a
// free body without rigid motion.
double unseen_load(const ReducedBody& reduced, const Vector& load, const Vector& response);

}  // namespace tremolo
