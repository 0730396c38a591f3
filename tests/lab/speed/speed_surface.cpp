// Cost of u = U q: positions and normals of a surface, compared with the row-by-row product in
// double and with the time for reading the rows.
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "runtime/body.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {
namespace {

// A surface of its own: the cost depends on sizes only.
struct Surface {
  VertexBlock block;
  std::vector<Triangle> triangles;
};

// A closed tube (a torus) of `around` x `along` vertices, numbered along: s = around * along,
// t = 2 s, as a solid's boundary has. Rows are multiples of 2^-15.
Surface make_surface(int around, int along, Eigen::Index r) {
  std::mt19937 engine(4);
  std::uniform_int_distribution<int> integer(-32767, 32767);
  Surface surface;
  const auto id = [&](int i, int j) { return (i % along) * around + j % around; };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      const double a = 2.0 * std::numbers::pi * i / along;
      const double b = 2.0 * std::numbers::pi * j / around;
      const double radius = 1.0 + 0.3 * std::cos(b);
      surface.block.vertex_ids.push_back(id(i, j));
      surface.block.rest.emplace_back(radius * std::cos(a), radius * std::sin(a),
                                      0.3 * std::sin(b));
      surface.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      surface.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  surface.block.rows = BasisRows::NullaryExpr(
      3 * around * along, r, [&] { return std::ldexp(double(integer(engine)), -15); });
  return surface;
}

// One caller's buffers, and the timed work. old_way: one row of doubles at a time.
struct Caller {
  const Surface* surface = nullptr;
  const SurfaceBasis* basis = nullptr;
  Eigen::VectorXd q;
  SurfaceWorkspace workspace;
  std::vector<float> positions, normals;
  std::vector<double> exact;

  void old_way() { row_by_row(positions); }
  void in_double() { row_by_row(exact); }
  void in_float() { surface_positions(*basis, q, workspace, positions); }
  void with_normals() {
    surface_with_normals(*basis, surface->triangles, q, workspace, positions, normals);
  }

 private:
  template <class Real>
  void row_by_row(std::vector<Real>& out) const {
    const VertexBlock& block = surface->block;
    for (std::size_t row = 0; row < out.size(); ++row)
      out[row] = static_cast<Real>(block.rest[row / 3][row % 3] + block.rows.row(row).dot(q));
  }
};

Caller make_caller(const Surface& surface, const SurfaceBasis& basis) {
  Caller caller;
  caller.surface = &surface;
  caller.basis = &basis;
  caller.q = Eigen::VectorXd::Constant(surface.block.rows.cols(), 1e-3);
  const std::size_t size = surface.block.rows.rows();
  caller.positions.resize(size);
  caller.normals.resize(size);
  caller.exact.resize(size);
  return caller;
}

// The memory level that holds `bytes` that are read repeatedly, and its bandwidth.
void set_bandwidth_limit(SpeedRow& row, const MachineProbe& probe) {
  const bool l2 = row.bytes < 0.75e6, l3 = row.bytes < 12e6;
  const double bandwidth = l2   ? probe.l2_bandwidth
                           : l3 ? probe.l3_bandwidth
                                : probe.memory_bandwidth;
  row.limited_by = l2 ? "L2 bandwidth" : l3 ? "L3 bandwidth" : "memory bandwidth";
  row.limit = 1e-3 * row.bytes / bandwidth;
}

void measure_size(int around, int along, Eigen::Index r, const MachineProbe& probe,
                  SpeedSection& section) {
  Surface surface = make_surface(around, along, r);
  const SurfaceBasis floats = make_surface_basis(surface.block, surface.triangles);
  surface.block.column_scales = Eigen::VectorXd::Constant(r, std::ldexp(1.0, -15));
  const SurfaceBasis integers = make_surface_basis(surface.block, surface.triangles);
  Caller wide = make_caller(surface, floats), narrow = make_caller(surface, integers);
  const double rows = static_cast<double>(surface.block.rows.rows());
  const int calls = std::max(1, static_cast<int>(2e6 / (rows * static_cast<double>(r))));
  const std::vector<double> seconds = by_turns(
      {[&] { wide.old_way(); }, [&] { wide.in_double(); }, [&] { wide.in_float(); },
       [&] { narrow.in_float(); }, [&] { wide.with_normals(); }, [&] { narrow.with_normals(); }},
      calls, 25);
  const double reals = rows * static_cast<double>(r);
  // Rest positions and results besides the rows. For normals the results once more, the corners,
  // the triangles' normals written and read three times, the lists of triangles, and the normals.
  const double vertices = rows / 3.0, triangles = 2.0 * vertices;
  const double normals = 8 * rows + (12.0 + 4 * 16.0 + 12.0) * triangles + 4 * vertices + 4 * rows;
  const struct {
    const char* what;
    double bytes;
  } kinds[] = {{"old way, row by row in f64, result in float", 8 * reals + 12 * rows},
               {"positions f64", 8 * reals + 16 * rows},
               {"positions f32", 4 * reals + 8 * rows},
               {"positions f32 from 16-bit rows", 2 * reals + 8 * rows},
               {"positions and normals f32", 4 * reals + 8 * rows + normals},
               {"positions and normals f32 from 16-bit rows", 2 * reals + 8 * rows + normals}};
  for (std::size_t i = 0; i < std::size(kinds); ++i) {
    SpeedRow row = microseconds(fmt::format("s = {}, r = {}: {}", around * along, r, kinds[i].what),
                                seconds[i], seconds[0]);
    row.bytes = kinds[i].bytes;
    row.operations = 2 * reals;
    set_bandwidth_limit(row, probe);
    section.rows.push_back(std::move(row));
  }
}

}  // namespace

SpeedSection measure_surface_speed(const Options&, const MachineProbe& probe) {
  SpeedSection section;
  section.title = "u = U q for display";
  section.text =
      "Positions X + U q of all s vertices of a surface, and their unit normals (each triangle "
      "counts with its area; 2 s triangles), into the caller's buffers. The textbook column is the "
      "product row by row in double; the limit is the time to move the bytes at the bandwidth of "
      "the level that holds them. 16-bit rows are those of a compact file.";
  measure_size(30, 100, 15, probe, section);
  measure_size(30, 100, 30, probe, section);
  measure_size(100, 100, 30, probe, section);
  measure_size(250, 800, 30, probe, section);
  return section;
}

}  // namespace tremolo::bench
