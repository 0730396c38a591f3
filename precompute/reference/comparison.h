// A reduced model against the unreduced body of the same mesh.
#pragma once

#include <limits>
#include <optional>

#include "formats/basis/basis_data.h"
#include "precompute/reference/full_order_solver.h"
#include "precompute/reference/reduced_model.h"

namespace tremolo {

// basis: N x r over the body's unknowns; mass_basis: M times it.
struct ReducedBody {
  ReducedModel model;
  Eigen::MatrixXd basis, mass_basis;
};

// basis: N x r over the body's unknowns.
ReducedBody make_reduced_body(const FullOrder& body, ReducedModel model, Eigen::MatrixXd basis);

// The first `modes` coordinates of the data (none given: all). mesh_hash: what the data's
// provenance must say. name: for messages. Throws Failure (kContent) for another mesh, other held
// vertices, and a basis that is not orthonormal in the body's mass or whose stiffness is not the
// body's, to 1e-6 (2 % of a compact file): then it was made of another material.
ReducedBody make_reduced_body(const FullOrder& body, const BasisData& data,
                              const std::string& mesh_hash, std::optional<int> modes,
                              const std::string& name);

// At one moment; u: the body's displacement, |.| in the M norm (kg^1/2 m).
struct Moment {
  double norm = 0;               // |u|
  double difference = 0;         // |u - U q|
  double projection = 0;         // |u - U U^T M u|: the least any q could leave
  double mac = 0;                // (u . Uq)^2 / (|u|^2 |Uq|^2), 1: the same shape
  double tip = 0;                // largest displacement of the watched vertices, m
  double tip_difference = 0;     // largest distance of the two there, m
  double energy_difference = 0;  // reduced minus full, kinetic and potential, J
};
// mass_u: M u.
Moment compare(const FullOrder& body, const ReducedBody& reduced, const Vector& u,
               const Vector& mass_u, const Vector& q, const std::vector<VertexId>& watched);

// The largest of each over the moments, dimensionless but for energy. *_of_largest: differences
// over the largest size of all moments. *_at_once: over the size of their own moment, of the
// moments whose size is at least a tenth of the largest. nan: nothing was measured, because nothing
// moved or no vertex is watched.
struct ComparisonSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double error_of_largest = kNone;
  double error_at_once = kNone;
  double projection_of_largest = kNone;
  double projection_at_once = kNone;
  double tip_error_of_largest = kNone;
  double mac_least = kNone;  // of those moments too
  double energy_difference = kNone;
};
ComparisonSummary summarise(const std::vector<Moment>& moments);

// 1 - f^T U Lambda^-1 U^T f / f^T K^-1 f: the part of the load's linear compliance (twice the
// elastic energy it stores in the linear body) that the basis leaves out. 0: the load's linear
// response is in the basis; nan for a load of zero. response: K^-1 f (linear_response()), on a free
// body that of the deformation alone.
double unseen_load(const ReducedBody& reduced, const Vector& load, const Vector& response);

}  // namespace tremolo
