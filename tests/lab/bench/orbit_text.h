// An orbit as text that gives back every bit.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

namespace tremolo::bench {

// 16 hexadecimal digits a number, column by column.
std::string orbit_text(const Eigen::MatrixXd& q);

// rows: of the matrix. What is not such a text gives an empty matrix.
Eigen::MatrixXd orbit_from_text(std::string_view text, Eigen::Index rows);

}  // namespace tremolo::bench
