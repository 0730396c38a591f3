// Products with matrices that consist of several square ones below each other, and sums of such
// blocks, in vectors.
#pragma once

#include <span>

#include <Eigen/Core>

namespace tremolo {

// The number of stored rows of a tall matrix of `rows` rows: the next multiple of a vector's
// length. Entries of padding rows are finite.
Eigen::Index tall_rows(Eigen::Index rows);

// The first tall_rows(rows) entries of y become those of A x. a: stored with at least as many rows,
// by columns, x: one entry a column, y: at least tall_rows(rows) long. Nothing is allocated.
void multiply_tall(const Eigen::MatrixXd& a, Eigen::Index rows, const Eigen::VectorXd& x,
                   Eigen::VectorXd& y);

// sum += sum_b weights[b] A_b, A_b the rows b r .. b r + r - 1 of a, r its number of columns. a:
// stored with at least tall_rows(r) rows from the start of its last block; sum: tall_rows(r) x r,
// whose last rows are undefined. Nothing is allocated.
void add_blocks(const Eigen::MatrixXd& a, std::span<const double> weights, Eigen::MatrixXd& sum);

}  // namespace tremolo
