#include "precompute/reference/world/pose_path.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "common/text.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Row = PosePath::Row;

// The slope at the first time, or the last, of the polynomial through the four rows there.
double end_slope(const std::vector<double>& times, const std::vector<Row>& rows, std::size_t part,
                 bool at_end) {
  const std::size_t count = std::min<std::size_t>(4, times.size());
  const auto index = [&](std::size_t i) { return at_end ? times.size() - 1 - i : i; };
  double slope = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // The derivative of Lagrange's polynomial i at point 0.
    double weight = 0;
    for (std::size_t skip = 0; skip < count; ++skip) {
      if (skip == i) continue;
      double product = 1.0 / (times[index(i)] - times[index(skip)]);
      for (std::size_t k = 0; k < count; ++k)
        if (k != i && k != skip)
          product *= (times[index(0)] - times[index(k)]) / (times[index(i)] - times[index(k)]);
      weight += product;
    }
    slope += weight * rows[index(i)][part];
  }
  return slope;
}

// Slopes of the spline at all times: those at the ends are known, and a tridiagonal system makes
// the second derivative continuous.
std::vector<double> spline_slopes(const std::vector<double>& times, const std::vector<Row>& rows,
                                  std::size_t part) {
  const std::size_t n = times.size();
  std::vector<double> slope(n), upper(n, 0.0);
  slope.front() = end_slope(times, rows, part, false);
  slope.back() = end_slope(times, rows, part, true);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = times[i] - times[i - 1], right = times[i + 1] - times[i];
    const double pivot = 2.0 / left + 2.0 / right - upper[i - 1] / left;
    upper[i] = 1.0 / right / pivot;
    const double value = 3.0 * ((rows[i][part] - rows[i - 1][part]) / (left * left) +
                                (rows[i + 1][part] - rows[i][part]) / (right * right));
    slope[i] = (value - slope[i - 1] / left) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) slope[i] -= upper[i] * slope[i + 1];
  return slope;
}

// Normalises each quaternion and chooses the nearer of the two that represent its rotation.
void align_quaternions(std::vector<Row>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::Map<Eigen::Vector4d> q(rows[i].data() + 3);
    const double length = q.norm();
    if (!(std::abs(length - 1.0) <= 1e-3))
      throw Failure(content_error(
          text("row %zu: the quaternion is of length %.6g, must be 1", i + 1, length)));
    q /= length;
    if (i == 0) continue;
    const double cosine = q.dot(Eigen::Map<const Eigen::Vector4d>(rows[i - 1].data() + 3));
    if (cosine < 0) q = -q;
    if (std::abs(cosine) < std::sqrt(0.5))
      throw Failure(
          content_error(text("from row %zu to the next the support turns by more than 90 "
                             "degrees: give more rows",
                             i)));
  }
}

}  // namespace

PosePath::PosePath(std::vector<double> times, std::vector<Row> rows)
    : times_(std::move(times)), rows_(std::move(rows)), slopes_(rows_.size()) {
  if (times_.size() < 2 || times_.size() != rows_.size())
    throw Failure(content_error("a motion has at least two rows"));
  for (std::size_t i = 0; i < times_.size(); ++i) {
    const bool finite = std::all_of(rows_[i].begin(), rows_[i].end(),
                                    [](double value) { return std::isfinite(value); });
    if (!finite || !std::isfinite(times_[i]))
      throw Failure(content_error(text("row %zu: a number is not finite", i + 1)));
    if (i > 0 && !(times_[i] > times_[i - 1]))
      throw Failure(content_error(text("row %zu: the times must ascend", i + 1)));
  }
  align_quaternions(rows_);
  for (std::size_t part = 0; part < rows_.front().size(); ++part) {
    const std::vector<double> slope = spline_slopes(times_, rows_, part);
    for (std::size_t i = 0; i < slope.size(); ++i) slopes_[i][part] = slope[i];
  }
}

RigidMotion PosePath::at(double time) const {
  const auto behind = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
  const auto i = static_cast<std::size_t>(behind - times_.begin()) - 1;
  const double length = times_[i + 1] - times_[i], s = (time - times_[i]) / length;
  std::array<double, 7> value, slope;
  for (std::size_t part = 0; part < value.size(); ++part) {
    const double a = rows_[i][part], change = rows_[i + 1][part] - a;
    const double c0 = length * slopes_[i][part], c1 = length * slopes_[i + 1][part];
    const double square = 3.0 * change - 2.0 * c0 - c1, cubic = c0 + c1 - 2.0 * change;
    value[part] = a + s * (c0 + s * (square + s * cubic));
    slope[part] = (c0 + s * (2.0 * square + 3.0 * s * cubic)) / length;
  }
  const Eigen::Quaterniond q(value[3], value[4], value[5], value[6]);
  const Eigen::Quaterniond rate(slope[3], slope[4], slope[5], slope[6]);
  // omega = 2 q' q* / |q|^2: the part of q' along q changes only the length, and is the real part
  // here.
  return {{value[0], value[1], value[2]},
          q.normalized().toRotationMatrix(),
          {slope[0], slope[1], slope[2]},
          (2.0 / q.squaredNorm()) * (rate * q.conjugate()).vec()};
}

PosePath read_pose_path(const std::string& path) {
  const std::string file = unwrap(read_whole_file(path));
  TextScanner scanner(file, path,
                      {.comment = '#', .commas = true, .lines = true, .open_end = true});
  std::vector<double> times;
  std::vector<Row> rows;
  bool more = !scanner.at_end();
  if (more) {
    const std::string_view word = scanner.peek();
    if (!word.empty() &&
        (std::isalpha(static_cast<unsigned char>(word.front())) != 0 || word.front() == '"'))
      more = scanner.next_line();
  }
  for (; more; more = scanner.next_line()) {
    double time = 0;
    Row row{};
    bool good = scanner.read(time, "a time in s");
    for (double& value : row) good = good && scanner.read(value, "x, y, z in m, qw, qx, qy, qz");
    if (good && !scanner.at_line_end())
      good = scanner.fail("eight numbers on a line: t, x, y, z, qw, qx, qy, qz", scanner.token());
    if (!good) throw Failure(scanner.error());
    times.push_back(time);
    rows.push_back(row);
  }
  try {
    return {std::move(times), std::move(rows)};
  } catch (const Failure& failure) {
    throw Failure(error_of_file(path, failure.error()));
  }
}

}  // namespace tremolo
