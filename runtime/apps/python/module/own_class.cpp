// The class tremolo.OwnBody: a potential of the user, written in Python, under the methods for
// point masses (runtime/step/nodal_integrator.h).
//
// Its coordinates are grouped by three as if they were nodes; the last node may have coordinates
// that no force moves. Masses are scaled away: y = sqrt(m) q has the mass 1.
#include "runtime/apps/python/module/own_class.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "runtime/apps/python/module/own_preserving.h"
#include "runtime/math/dense/decompositions.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo::python {
namespace {

// The user's functions of q.
struct Callables {
  py::object energy, gradient;
  py::object tangent;  // None: by differences of the gradient
};

class OwnSystem : public NodalSystem, public OwnPotential {
 public:
  OwnSystem(Callables calls, Eigen::VectorXd roots, BlockPatternPointer pattern)
      : calls_(std::move(calls)),
        roots_(std::move(roots)),
        pattern_(std::move(pattern)),
        mass_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(pattern_->size()))),
        held_(pattern_->size(), 0) {}

  Eigen::Index coordinates() const override { return roots_.size(); }
  const Eigen::VectorXd& roots() const { return roots_; }

  std::size_t size() const override { return pattern_->size(); }
  const Eigen::VectorXd& mass() const override { return mass_; }
  std::span<const std::uint8_t> held() const override { return held_; }
  const BlockPatternPointer& pattern() const override { return pattern_; }
  double load_size() const override { return largest_ > 0.0 ? largest_ : 1.0; }
  void put_held(double, Eigen::VectorXd&) const override {}
  void note_force(double size) const { largest_ = std::max(largest_, size); }

  double potential(const Eigen::VectorXd& y) const override {
    return calls_.energy(q_of(y)).cast<double>();
  }
  double value(const Eigen::VectorXd& y) const override { return potential(y); }
  Eigen::VectorXd slope(const Eigen::VectorXd& y) const override {
    Eigen::VectorXd g = gradient(y);
    note_force(g.norm());
    return g;
  }
  double force_size() const override { return load_size(); }
  StepWork power(const Eigen::VectorXd&, const Eigen::VectorXd&) const override { return {}; }

  void force(const Eigen::VectorXd& y, const Eigen::VectorXd&, ForcePart part,
             Eigen::VectorXd& f) const override {
    f.setZero(y.size());
    if (part == ForcePart::kSoft) return;
    const Eigen::VectorXd g = gradient(y);
    f.head(g.size()) = -g;
    note_force(g.norm());
  }

  // The discrete gradient of Gonzalez: that of the middle, corrected along the way so that its work
  // is the change of the energy.
  StepWork step_force(const Eigen::VectorXd& y0, const Eigen::VectorXd& y1, double,
                      Eigen::VectorXd& f) const override {
    const Eigen::VectorXd way = y1 - y0;
    force(0.5 * (y0 + y1), way, ForcePart::kAll, f);
    const double square = way.squaredNorm();
    if (square > 0.0) f -= ((potential(y1) - potential(y0) + f.dot(way)) / square) * way;
    return {};
  }

  void add_tangent(const Eigen::VectorXd& y, const Eigen::VectorXd&, ForcePart part,
                   double position, double, double share, BlockMatrix& a) const override {
    if (part == ForcePart::kSoft || position == 0.0) return;
    const Eigen::MatrixXd all = tangent(y);
    if (share == 1.0) return add_dense(position * all, a);
    const SymmetricEigen solver = symmetric_eigen(all);
    const Eigen::VectorXd values = solver.values.unaryExpr(
        [share](double value) { return value > 0.0 ? value : share * value; });
    add_dense(position * solver.vectors * values.asDiagonal() * solver.vectors.transpose(), a);
  }
  void add_step_tangent(const Eigen::VectorXd& y0, const Eigen::VectorXd& y1, double h,
                        double share, BlockMatrix& a) const override {
    (void)h;
    add_tangent(0.5 * (y0 + y1), y0, ForcePart::kAll, 0.5, 0.0, share, a);
  }

  Eigen::MatrixXd tangent(const Eigen::VectorXd& y) const override {
    const Eigen::Index r = coordinates();
    Eigen::MatrixXd k(r, r);
    if (calls_.tangent.is_none()) {
      const Eigen::VectorXd middle = gradient(y);
      const double distance = 1e-7 * std::max(1e-3, y.norm());
      Eigen::VectorXd moved = y;
      for (Eigen::Index i = 0; i < r; ++i) {
        moved[i] += distance;
        k.col(i) = (gradient(moved) - middle) / distance;
        moved[i] = y[i];
      }
    } else {
      const Doubles given = numbers(calls_.tangent(q_of(y)), "the tangent's result");
      if (given.ndim() != 2 || given.shape(0) != r || given.shape(1) != r)
        raise(usage_error("the tangent's result: expected the shape (" + std::to_string(r) + ", " +
                          std::to_string(r) + "), found " + shape_text(given)));
      k = Eigen::Map<const Eigen::MatrixXd>(given.data(), r, r);
      k = roots_.cwiseInverse().asDiagonal() * k * roots_.cwiseInverse().asDiagonal();
    }
    const Eigen::MatrixXd symmetric = 0.5 * (k + k.transpose());
    // A solver of eigenvalues does not end for numbers that are none.
    return symmetric.allFinite() ? symmetric : Eigen::MatrixXd::Zero(r, r);
  }

 private:
  py::array_t<double> q_of(const Eigen::VectorXd& y) const {
    const Eigen::VectorXd q = y.head(coordinates()).cwiseQuotient(roots_);
    return array_of<Eigen::Dynamic>(q);
  }
  // By y.
  Eigen::VectorXd gradient(const Eigen::VectorXd& y) const {
    const Doubles g = numbers(calls_.gradient(q_of(y)), "the gradient's result");
    if (g.ndim() != 1 || g.shape(0) != coordinates())
      raise(usage_error("the gradient's result: expected the shape (" +
                        std::to_string(coordinates()) + ",), found " + shape_text(g)));
    return Eigen::Map<const Eigen::VectorXd>(g.data(), g.size()).cwiseQuotient(roots_);
  }
  static void add_dense(const Eigen::MatrixXd& dense, BlockMatrix& a) {
    const Eigen::Index r = dense.rows();
    for (std::size_t i = 0; i < a.pattern().size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        Eigen::Matrix3d& block = a.block(a.pattern().find(i, j));
        const auto row = static_cast<Eigen::Index>(3 * i),
                   column = static_cast<Eigen::Index>(3 * j);
        const Eigen::Index rows = std::min<Eigen::Index>(3, r - row);
        const Eigen::Index columns = std::min<Eigen::Index>(3, r - column);
        block.topLeftCorner(rows, columns) += dense.block(row, column, rows, columns);
      }
  }

  Callables calls_;
  Eigen::VectorXd roots_;  // square roots of the masses, r
  BlockPatternPointer pattern_;
  Eigen::VectorXd mass_;
  std::vector<std::uint8_t> held_;
  mutable double largest_ = 0.0;  // force so far
};

struct OwnBody {
  std::unique_ptr<OwnSystem> system;
  std::unique_ptr<NodalIntegrator> integrator;
  NodalState state;
  double step = 0.0;  // s
  std::int64_t steps = 0;
  std::atomic<bool> used = false;
};

Eigen::VectorXd scaled(const OwnBody& self, py::handle values, const char* name) {
  const Eigen::VectorXd& roots = self.system->roots();
  Eigen::VectorXd y = Eigen::VectorXd::Zero(self.state.x.size());
  y.head(roots.size()) = vector(values, roots.size(), name).cwiseProduct(roots);
  return y;
}

std::vector<std::string_view> method_names() {
  const auto nodal = nodal_integrator_names();
  std::vector<std::string_view> names(nodal.begin(), nodal.end());
  names.insert(names.end(), {"avf", "ep4"});
  return names;
}

std::unique_ptr<OwnBody> make_own(py::object energy, py::object gradient, py::object tangent,
                                  py::handle q, py::handle v, py::handle mass,
                                  const std::string& integrator, double step, double tolerance) {
  for (const auto& [call, name] : {std::pair(energy, "energy"), std::pair(gradient, "gradient")})
    if (PyCallable_Check(call.ptr()) == 0)
      raise_type(std::string(name) + ": expected a callable, found " +
                 Py_TYPE(call.ptr())->tp_name);
  if (!tangent.is_none() && PyCallable_Check(tangent.ptr()) == 0)
    raise_type("tangent: expected a callable or None");
  const Doubles start = finite_numbers(q, "q");
  if (start.ndim() != 1 || start.size() == 0)
    raise(usage_error("q: expected the shape (r,), found " + shape_text(start)));
  const Eigen::Index r = start.size();
  Eigen::VectorXd masses = Eigen::VectorXd::Ones(r);
  if (!mass.is_none()) masses = vector(mass, r, "mass");
  if (!(masses.minCoeff() > 0.0)) raise(content_error("mass: every mass must be positive"));
  const auto nodes = static_cast<std::size_t>((r + 2) / 3);
  std::vector<NodePair> pairs;
  for (std::uint32_t i = 0; i < nodes; ++i)
    for (std::uint32_t j = 0; j < i; ++j) pairs.emplace_back(i, j);

  auto made = std::make_unique<OwnBody>();
  made->system = std::make_unique<OwnSystem>(
      Callables{std::move(energy), std::move(gradient), std::move(tangent)}, masses.cwiseSqrt(),
      unwrap(BlockPattern::create(nodes, pairs)));
  made->step = step;
  made->state.x = made->state.v = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * nodes));
  made->state.x = scaled(*made, start, "q");
  if (!v.is_none()) made->state.v = scaled(*made, v, "v");
  NodalOptions options;
  options.step = step;
  options.tolerance = tolerance;
  options.solver = NodalSolver::kCholesky;
  options.account = false;
  const std::vector<std::string_view> known = method_names();
  if (std::find(known.begin(), known.end(), integrator) == known.end()) {
    std::string names;
    for (const std::string_view each : known) names += " " + std::string(each);
    raise(usage_error("unknown integrator '" + integrator + "'; known:" + names));
  }
  const bool preserving = integrator == "avf" || integrator == "ep4";
  // The options are checked by the other methods.
  made->integrator =
      unwrap(make_nodal_integrator(preserving ? "energy" : integrator, *made->system, options));
  if (preserving) made->integrator = make_preserving(integrator, *made->system, options);
  made->system->note_force(made->state.v.norm() / step);
  return made;
}

void step(OwnBody& self, std::int64_t count) {
  const InUse used(self.used, "body");
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  for (std::int64_t k = 0; k < count; ++k) {
    const NodalState before = self.state;
    try {
      const NodalReport report = self.integrator->step(self.state);
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      const bool finite = self.state.x.allFinite() && self.state.v.allFinite();
      if (!report.made || !finite)
        raise({ErrorKind::kSolver, "the step from " + text_of(py::float_(before.time)) +
                                       " s failed: " +
                                       (finite ? "its equation was not solved"
                                               : "a number is not finite; take a shorter step")});
    } catch (...) {
      self.state = before;
      self.integrator->reset();
      throw;
    }
    ++self.steps;
  }
}

py::array_t<double> unscaled(const OwnBody& self, const Eigen::VectorXd& y) {
  const Eigen::VectorXd& roots = self.system->roots();
  return array_of<Eigen::Dynamic>(y.head(roots.size()).cwiseQuotient(roots));
}

py::dict energy(OwnBody& self) {
  const InUse used(self.used, "body");
  py::dict dict;
  const double kinetic = 0.5 * self.state.v.squaredNorm();
  const double potential = self.system->potential(self.state.x);
  dict["kinetic"] = kinetic;
  dict["potential"] = potential;
  dict["total"] = kinetic + potential;
  return dict;
}

}  // namespace

void add_own(py::module_& module) {
  py::class_<OwnBody> c(module, "OwnBody",
                        "Coordinates in a potential of your own; tremolo.own_body makes one.");
  c.def_property(
      "q", [](const OwnBody& self) { return unscaled(self, self.state.x); },
      [](OwnBody& self, py::handle q) {
        const InUse used(self.used, "body");
        self.state.x = scaled(self, q, "q");
        self.integrator->reset();
      },
      "Coordinates, (r,). A copy; assign to change them.");
  c.def_property(
      "v", [](const OwnBody& self) { return unscaled(self, self.state.v); },
      [](OwnBody& self, py::handle v) {
        const InUse used(self.used, "body");
        self.state.v = scaled(self, v, "v");
        self.integrator->reset();
      },
      "Velocities, (r,). A copy; assign to change them.");
  c.def("step", &step, py::arg("n") = 1,
        "Takes n steps. An exception of a callable, or Ctrl-C, leaves the state before that step.");
  c.def_property_readonly("energy", &energy, "kinetic, potential and total, a dict.");
  c.def_property_readonly(
      "time", [](const OwnBody& self) { return static_cast<double>(self.steps) * self.step; },
      "s.");
  c.def_property_readonly(
      "steps", [](const OwnBody& self) { return self.steps; }, "Number of steps taken.");
  refuse_construction(c, "tremolo.own_body() makes one");
  module.def("own_body", &make_own, py::arg("energy"), py::arg("gradient"),
             py::arg("tangent") = py::none(), py::kw_only(), py::arg("q"),
             py::arg("v") = py::none(), py::arg("mass") = py::none(),
             py::arg("integrator") = "energy", py::arg("step") = 3e-3, py::arg("tolerance") = 1e-9,
             "Coordinates in a potential of your own: m q'' = -grad V(q). energy(q): V, a float; "
             "gradient(q): (r,); tangent(q): (r, r), or None: by differences of the gradient. q, "
             "v: (r,), the state at time 0. mass: (r,), by default 1. integrator: one of "
             "own_integrators(). \"energy\", \"avf\" and \"ep4\" keep the energy at any step; "
             "\"ep4\" is of fourth order. Each evaluation is a call of Python: some microseconds, "
             "a hundred times as slow as a model's own.");
  module.def(
      "own_integrators",
      [] {
        py::list names;
        for (const std::string_view name : method_names()) names.append(py::str(name));
        return names;
      },
      "The names of the methods of own_body, a list of str.");
}

}  // namespace tremolo::python
