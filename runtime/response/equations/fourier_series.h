// Periodic functions of time as Fourier series, x(t) = c_0 + sum_k a_k cos k theta + b_k sin k
// theta, theta = omega t.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// The coefficients, r x (2H + 1), in the order c_0, a_1, b_1, a_2, b_2, ..., b_H.
using FourierSeries = Eigen::MatrixXd;

inline Eigen::Index harmonics_of(const FourierSeries& series) {
  return (series.cols() - 1) / 2;
}
inline Eigen::Index cosine_column(Eigen::Index k) {
  return 2 * k - 1;
}
inline Eigen::Index sine_column(Eigen::Index k) {
  return 2 * k;
}

// The factors of the coefficients at the angle theta: 1, cos theta, sin theta, ..., 2H + 1.
Eigen::VectorXd fourier_row(Eigen::Index harmonics, double theta);
// The same for the derivative with respect to theta.
Eigen::VectorXd fourier_slope_row(Eigen::Index harmonics, double theta);

// The series with so many harmonics: missing ones are zero, higher ones are left out.
FourierSeries with_harmonics(const FourierSeries& series, Eigen::Index harmonics);

// The series of x(t + shift / omega): all angles advance by `shift`, rad.
FourierSeries shifted(const FourierSeries& series, double shift);

// The odd harmonics alone; the others are zero.
FourierSeries odd_harmonics(const FourierSeries& series);

// A motion of period T/2 as one of period T: harmonic k becomes harmonic 2k. And back, of the even
// harmonics of a motion of period T.
FourierSeries doubled_period(const FourierSeries& series);
FourierSeries halved_period(const FourierSeries& series);

// The size of harmonic k: the root of the mean square of a_k and b_k over both, or |c_0| for k = 0.
double harmonic_size(const FourierSeries& series, Eigen::Index k);

// The share of the two highest harmonics in all that move, 0 to 1. Two, since a symmetric body has
// odd harmonics only. The first is one of them only if there is no other.
double last_share(const FourierSeries& series);

// The largest |rows x(t) + offset| over a period, found to rounding. rows: p x r.
struct PeriodicPeak {
  double value = 0.0;
  double theta = 0.0;  // rad, 0 to 2 pi
};
PeriodicPeak largest_over_period(const Eigen::MatrixXd& rows, const FourierSeries& series);

}  // namespace tremolo
