#include "precompute/reduction/basis.h"

#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

#include "common/packed_index.h"
#include "common/text.h"
#include "common/units.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/dense/parallel_columns.h"
#include "precompute/dense/sparse_rows.h"
#include "precompute/reduction/many_columns.h"
#include "precompute/reduction/third_derivatives.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Returns the weights of the columns in a motion u = sum Psi_i p_i + 1/2 sum Phi_ij p_i p_j + 1/6
// sum Xi_ijl p_i p_j p_l with amplitudes p_i = a w2_1/w2_i, divided by a.
Eigen::VectorXd weights(const Eigen::VectorXd& w2, double amplitude, Eigen::Index columns) {
  const Eigen::Index k = w2.size();
  const Eigen::VectorXd share = w2[0] * w2.cwiseInverse();
  Eigen::VectorXd weight(columns);
  weight.head(k) = share;
  if (columns == k) return weight;
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i <= j; ++i)
      weight[k + pair_index(i, j)] = 0.5 * amplitude * share[i] * share[j];
  Eigen::Index at = k + pair_count(k);
  for (const auto& [i, j, l] : third_orders_of(k, columns)) {
    // The number of times that the sum has it: 1, 3 or 6 of 6.
    const double often = i == l ? 1.0 / 6.0 : i == j || j == l ? 0.5 : 1.0;
    weight[at++] = often * amplitude * amplitude * share[i] * share[j] * share[l];
  }
  return weight;
}

// Computes X <- X P by blocks of rows. P has at most as many columns as X; the remaining columns of
// X are unchanged.
void transform(ColumnsOut x, const Eigen::MatrixXd& p, unsigned threads) {
  constexpr Eigen::Index kRows = 1024;
  const BlasThreads single(1);
  parallel_columns(x.rows(), kRows, threads, [&](Eigen::Index first, Eigen::Index count) {
    const Columns block = x.middleRows(first, count);
    add_product(1.0, block, p, 0.0, x.block(first, 0, count, p.cols()));
  });
}

// Uses BLAS for large products only; small ones keep the digits of earlier models.
Eigen::MatrixXd product_of(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.cols() < kLarge) return a * b;
  Eigen::MatrixXd c(a.rows(), b.cols());
  add_product(1.0, a, b, 0.0, c);
  return c;
}

// Factorises W = columns * weight as W = Q T with Q^T M Q = I. Since a Gram matrix squares the
// condition number, columns are first scaled to unit M-norm and compressed to the directions it can
// resolve. A second pass on the compressed, now well-conditioned columns makes Q orthonormal to
// rounding. The first `rank` columns are changed in place, and Q = columns * q.
Factored orthonormalise(Mat mass, Columns& columns, const Eigen::VectorXd& weight,
                        unsigned threads) {
  const Eigen::MatrixXd first = gram(mass, columns, threads);
  // A column may be zero: modes of disconnected parts have no common derivative.
  const Eigen::VectorXd norms =
      first.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const Eigen::MatrixXd scaled =
      norms.cwiseInverse().asDiagonal() * first * norms.cwiseInverse().asDiagonal();
  const EigenPairs eigen = eigenpairs(scaled);
  constexpr double kResolved = 1e-12;  // relative to the largest: resolution of a Gram matrix
  const double largest = eigen.values.maxCoeff();
  Factored factored;
  factored.rank = (eigen.values.array() > kResolved * largest).count();
  const Eigen::VectorXd root = eigen.values.tail(factored.rank).cwiseSqrt();
  const Eigen::MatrixXd directions = eigen.vectors.rightCols(factored.rank);
  transform(columns,
            norms.cwiseInverse().asDiagonal() * directions * root.cwiseInverse().asDiagonal(),
            threads);
  const Eigen::LLT<Eigen::MatrixXd> second(gram(mass, columns.leftCols(factored.rank), threads));
  factored.q = second.matrixU().solve(Eigen::MatrixXd::Identity(factored.rank, factored.rank));
  factored.t = second.matrixU() * (root.asDiagonal() * directions.transpose() *
                                   norms.cwiseProduct(weight).asDiagonal());
  return factored;
}

// Makes the directions of the cluster at the cut canonical.
void choose_at_cut(Mat mass, const Marker& marker, const Cluster& cut,
                   PrincipalColumns& principal) {
  const Eigen::MatrixXd old = principal.turn.middleCols(cut.first, cut.count);
  Columns equals(principal.columns.rows(), cut.count);
  add_product(1.0, principal.columns, old, 0.0, equals);
  principal.turn.middleCols(cut.first, cut.count) = old * canonical_rotation(mass, marker, equals);
}

constexpr double kSameFrequency = 0.02;  // a frequency at most so much higher is the mesh's

// Returns by how much the frequencies of a basis are above those of the modes, relative.
Eigen::VectorXd too_high(const Eigen::VectorXd& lambda, const Eigen::VectorXd& w2) {
  const Eigen::Index count = std::min(lambda.size(), w2.size());
  return (lambda.head(count).array() / w2.head(count).array()).sqrt() - 1.0;
}

void find_directions(PrincipalColumns& principal) {
  constexpr double kRank =
      1e-13;  // relative to the largest singular value; smaller ones are rounding
  const SingularPairs pairs = singular_pairs(principal.t, SingularVectors::kLeft);
  principal.singular_values = pairs.values;
  principal.rank =
      (principal.singular_values.array() > kRank * principal.singular_values[0]).count();
  principal.turn = product_of(principal.q, pairs.vectors);
}

}  // namespace

Columns PrincipalColumns::first(Eigen::Index r) const {
  Columns result(columns.rows(), r);
  result.leftCols(kept.cols()) = kept;
  const Eigen::Index others = r - kept.cols();
  add_product(1.0, columns, turn.leftCols(others), 0.0, result.rightCols(others));
  return result;
}

PrincipalColumns principal_columns(const Matrices& matrices, Columns columns,
                                   const Eigen::VectorXd& w2, double amplitude, unsigned threads,
                                   const Progress& progress) {
  PrincipalColumns principal;
  principal.linear_modes = w2.size();
  const Mat mass = matrices.mass.get();
  const Eigen::VectorXd weight = weights(w2, amplitude, columns.cols());
  // The thread count must be set before any other use of BLAS here; it is restored at the end.
  const bool many = columns.cols() >= kLarge;
  const BlasThreads all(many ? static_cast<int>(threads) : blas_thread_count());
  Factored factored = many ? orthonormalise_many(mass, columns, weight, threads, progress)
                           : orthonormalise(mass, columns, weight, threads);
  columns.conservativeResize(Eigen::NoChange, factored.rank);
  principal.kept.resize(columns.rows(), 0);
  principal.columns = std::move(columns);
  principal.q = std::move(factored.q);
  principal.t = std::move(factored.t);
  if (many && progress)
    progress(text("singular values of %d rows", static_cast<int>(factored.rank)));
  find_directions(principal);
  return principal;
}

void keep_always(const Matrices& matrices, Columns vectors, unsigned threads,
                 PrincipalColumns& principal) {
  constexpr double kLeft = 1e-12;  // squared norm left of a direction that the vectors contain
  const Mat mass = matrices.mass.get();
  const Eigen::VectorXd norms = gram(mass, vectors, threads).diagonal().cwiseSqrt();
  vectors = Columns(vectors * norms.cwiseInverse().asDiagonal());
  const Eigen::LLT<Eigen::MatrixXd> factor(gram(mass, vectors, threads));
  transform(vectors,
            factor.matrixU().solve(Eigen::MatrixXd::Identity(vectors.cols(), vectors.cols())),
            threads);
  Eigen::MatrixXd shares = transposed_product(product(mass, vectors, threads), principal.columns);
  sum_over_ranks(shares);
  add_product(-1.0, vectors, shares, 1.0, principal.columns);
  // columns * q is no longer orthonormal: its Gram matrix is I - A^T A, A = held.
  const Eigen::MatrixXd held = shares * principal.q;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(held.cols(), held.cols());
  const EigenPairs left = eigenpairs(identity - held.transpose() * held);
  const auto count = (left.values.array() > kLeft).count();
  const Eigen::VectorXd root = left.values.tail(count).cwiseSqrt();
  const Eigen::MatrixXd directions = left.vectors.rightCols(count);
  principal.q =
      Eigen::MatrixXd(product_of(principal.q, directions) * root.cwiseInverse().asDiagonal());
  principal.t = product_of(root.asDiagonal() * directions.transpose(), principal.t);
  principal.kept = std::move(vectors);
  find_directions(principal);
}

Eigen::Index lowest_modes(const Eigen::VectorXd& w2, int r) {
  Eigen::Index count = std::min<Eigen::Index>(w2.size(), r / 2);
  // Pairs of a symmetric body: its mesh is less symmetric.
  constexpr double kPair = 1e-3;
  const Cluster divided = cluster_at_cut(w2, count, {kPair});
  if (divided.count > 0) count = divided.first + divided.count;
  return std::min<Eigen::Index>(count, r - 1);
}

Eigen::Index keep_lowest_modes(const Matrices& matrices, const Columns& modes,
                               const Eigen::VectorXd& w2, int r, std::optional<int> asked,
                               unsigned threads, PrincipalColumns& principal) {
  constexpr double kTooHigh = 0.1;  // of a mode among r/2; among r/4 kSameFrequency is too high
  const Eigen::Index count = asked ? Eigen::Index{*asked} : lowest_modes(w2, r);
  if (count < 1 || r > principal.size()) return 0;
  if (!asked) {
    const Columns cut = principal.first(r);
    const Eigen::VectorXd lambda = eigenpairs(gram(matrices.stiffness.get(), cut, threads),
                                              gram(matrices.mass.get(), cut, threads))
                                       .values;
    const Eigen::VectorXd high = too_high(lambda, w2.head(count));
    const auto lowest = high.head(std::min<Eigen::Index>(count, r / 4)).array();
    if ((high.array() <= kTooHigh).all() && (lowest <= kSameFrequency).all()) return 0;
  }
  keep_always(matrices, modes.leftCols(count), threads, principal);
  return count;
}

Basis make_basis(const Matrices& matrices, Columns columns, const Eigen::VectorXd& w2,
                 double amplitude, const BasisCut& cut) {
  PrincipalColumns principal =
      principal_columns(matrices, std::move(columns), w2, amplitude, cut.threads);
  return make_basis(matrices, std::move(principal), cut);
}

Basis make_basis(const Matrices& matrices, PrincipalColumns principal, const BasisCut& cut) {
  const auto [asked, threads, marker, extend] = cut;
  int r = asked;
  const Mat mass = matrices.mass.get();
  const Eigen::VectorXd& sigma = principal.singular_values;
  const Eigen::Index kept = principal.kept.cols();
  if (r < 1 || r <= kept || r > principal.size())
    throw Failure(content_error(
        std::to_string(r) + " coordinates asked for; " + std::to_string(principal.linear_modes) +
        " linear modes with their derivatives span " + std::to_string(principal.size())));
  Basis basis;
  // Kept vectors count as much as the first direction.
  basis.singular_values.assign(kept, sigma[0]);
  basis.singular_values.insert(basis.singular_values.end(), sigma.begin(), sigma.end());
  if (marker != nullptr) {
    basis.cut = cluster_at_cut(sigma.head(principal.rank), r - kept, {});
    const auto end = kept + basis.cut.first + basis.cut.count;
    if (extend && end > r && end - r <= kMostAdded)
      r = static_cast<int>(end);
    else if (basis.cut.count > 0)
      choose_at_cut(mass, *marker, basis.cut, principal);
    basis.cut.first += kept;
  }
  Columns reduced = principal.first(r);
  principal.columns.resize(0, 0);

  // The generalised eigenproblem corrects the remaining deviation from orthonormality.
  const EigenPairs rotation =
      eigenpairs(gram(matrices.stiffness.get(), reduced, threads), gram(mass, reduced, threads));
  basis.lambda = rotation.values;
  transform(reduced, rotation.vectors, threads);
  // Rotating these coordinates adds off-diagonal entries as large as their Lambdas differ, i.e.
  // rounding.
  const Nearness equal{1e-9, 1e-12 * basis.lambda[r - 1]};
  if (marker != nullptr) make_canonical(mass, *marker, find_clusters(basis.lambda, equal), reduced);
  basis.vectors = std::move(reduced);

  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  basis.orthonormality_error =
      (gram(mass, basis.vectors, threads) - identity).cwiseAbs().maxCoeff();
  Eigen::MatrixXd stiffness = gram(matrices.stiffness.get(), basis.vectors, threads);
  stiffness.diagonal() -= basis.lambda;
  basis.diagonality_error = stiffness.cwiseAbs().maxCoeff() / basis.lambda.maxCoeff();
  return basis;
}

std::string note_on_modes(const Eigen::VectorXd& lambda, const Eigen::VectorXd& w2) {
  constexpr int kMostNamed = 4;
  const Eigen::VectorXd high = too_high(lambda, w2);
  std::string named;
  int count = 0;
  for (Eigen::Index i = 0; i < high.size(); ++i) {
    if (high[i] <= kSameFrequency || ++count > kMostNamed) continue;
    named += text("%s%d (%.4g Hz in the mesh, %.4g in the model)", named.empty() ? "" : ", ",
                  static_cast<int>(i + 1), hertz(w2[i]), hertz(lambda[i]));
  }
  if (count == 0) return "";
  if (count > kMostNamed) named += text(" and %d more", count - kMostNamed);
  const auto modes = static_cast<int>(w2.size());
  std::string advice = "more --modes bring them nearer";
  if (2 * modes > lambda.size())
    advice = text("--modes %d, or fewer --linear-modes, bring them nearer", 2 * modes);
  return text("%d of the %d linear modes %s more than 2 %% too high: ", count, modes,
              count == 1 ? "is" : "are") +
         named + "; " + advice + ", --keep-modes takes them as they are, --linear has them all";
}

std::string note_on_cut(const Cluster& cut, Eigen::Index asked, Eigen::Index kept) {
  if (cut.count == 0) return "";
  const auto end = static_cast<int>(cut.first + cut.count);
  const std::string same = text("coordinates %d to %d weigh the same in the basis",
                                static_cast<int>(cut.first + 1), end);
  if (kept > asked)
    return text("%d coordinates, not %d: ", static_cast<int>(kept), static_cast<int>(asked)) + same;
  return same + text("; --modes %d takes all of them", end);
}

}  // namespace tremolo
