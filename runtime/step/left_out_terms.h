// The share of the indefinite terms that Newton's matrix of a step lacks, so that it has a factor.
#pragma once

#include <algorithm>

namespace tremolo {

// All terms are kept at first. After a matrix that was positive definite the next one lacks a
// fraction of what that one lacked, and in the end nothing; where it is not, several times as much.
class LeftOutTerms {
 public:
  // The fraction that the matrix lacks, 0 to 1; 1: it is positive definite.
  double fraction() const { return fraction_; }
  double kept() const { return 1.0 - fraction_; }
  void set(double fraction) { fraction_ = fraction; }
  // Call this for the next matrix.
  void less() { fraction_ = fraction_ < kLeast ? 0.0 : 0.4 * fraction_; }
  // Call this if the matrix was not positive definite.
  void more() { fraction_ = std::min(1.0, 4.0 * std::max(kLeast, fraction_)); }

 private:
  static constexpr double kLeast = 0.03;
  double fraction_ = 0.0;
};

}  // namespace tremolo
