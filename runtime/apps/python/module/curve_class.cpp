// Model.response and Model.backbone: curves of periodic motions as dicts of arrays.
#include <cmath>
#include <numbers>

#include "common/damping_ratios.h"
#include "runtime/apps/python/module/model_class.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/load.h"
#include "runtime/place_forces.h"
#include "runtime/response/backbone.h"
#include "runtime/response/branches.h"
#include "runtime/response/probe.h"
#include "runtime/response/response.h"

namespace tremolo::python {
namespace {

using namespace pybind11::literals;

constexpr double kTurn = 2.0 * std::numbers::pi;

// The damping of a curve, as in Model.body. Raises.
VibratingSystem system_of(const Model& model, double alpha, double beta, py::handle ratio) {
  Eigen::VectorXd more;
  if (!ratio.is_none()) {
    if (alpha != 0.0 || beta != 0.0)
      raise(usage_error("damping_ratio gives the damping: leave alpha and beta out"));
    const DampingRatios ratios = damping_ratios_of(ratio);
    alpha = ratios.rayleigh.alpha;
    beta = ratios.rayleigh.beta;
    check(check_ratios(ratios, static_cast<std::size_t>(model.modes())));
    more = modal_rates(ratios, model.lambda());
  }
  for (const double rate : {alpha, beta})
    if (!(rate >= 0.0) || !std::isfinite(rate))
      raise(content_error("alpha and beta must be finite and not negative"));
  return unwrap(vibrating_system(model, alpha, beta, more));
}

// Of the boundary's vertices, or of those that `at` names, the one that moves most in the mode.
Probe probe_of(py::handle at, const Model& model, Eigen::Index mode) {
  const std::vector<VertexId> vertices =
      at.is_none() ? model.surface().vertex_ids : vertices_at(at, model);
  Probe probe = unwrap(moving_most(model, vertices, mode));
  if (!probe.moves)
    raise(content_error("the probe is fixed: it does not move, so that it has no amplitude"));
  return probe;
}

// The probe's stored response to the default load, which a reduced force does not have.
ProbeResponse probe_response_of(const Model& model, const Probe& probe, py::handle load,
                                double load_scale, const FourierSeries& course) {
  if (!load.is_none()) return {};
  return unwrap(probe_response(
      model, probe.vertex, load_scale * place_forces_of(model, model.default_load()), course, 0.0));
}

CurveOptions options_of(int harmonics, Eigen::Index usual_most, bool stability, const Probe& probe,
                        double largest) {
  if (harmonics < 1 || harmonics > 99) raise(content_error("harmonics must be from 1 to 99"));
  CurveOptions options;
  options.harmonics = harmonics;
  options.most_harmonics = std::max<Eigen::Index>(harmonics, usual_most);
  options.stability = stability;
  options.largest_amplitude = largest;
  options.amplitude = amplitude_of(probe);
  // Ctrl-C ends the curve, which is then raised.
  options.stopped = [] {
    const py::gil_scoped_acquire locked;
    return PyErr_CheckSignals() != 0;
  };
  return options;
}

// load_scale: of a point whose load has the factor 1.
py::dict dict_of(const MotionCurve& curve, const VibratingSystem& system, double load_scale) {
  if (curve.end == CurveEnd::kStopped && PyErr_Occurred() != nullptr) throw py::error_already_set();
  const auto count = static_cast<py::ssize_t>(curve.points.size());
  py::array_t<double> frequencies(count), amplitudes(count), energies(count), shares(count),
      loads(count);
  py::array_t<bool> stable(count);
  py::array_t<int> harmonics(count);
  py::list motions, bifurcations;
  for (py::ssize_t i = 0; i < count; ++i) {
    const CurvePoint& point = curve.points[static_cast<std::size_t>(i)];
    frequencies.mutable_at(i) = point.omega / kTurn;
    amplitudes.mutable_at(i) = point.amplitude;
    energies.mutable_at(i) = mean_energy(system, point.motion, point.omega);
    shares.mutable_at(i) = point.share;
    loads.mutable_at(i) = load_scale * point.load;
    stable.mutable_at(i) = point.stable;
    harmonics.mutable_at(i) = static_cast<int>(point.harmonics());
    motions.append(py::array_t<double>(
        {point.motion.rows(), point.motion.cols()},
        {sizeof(double), sizeof(double) * static_cast<std::size_t>(point.motion.rows())},
        point.motion.data()));
  }
  for (const Bifurcation& found : curve.bifurcations)
    bifurcations.append(py::dict(
        "kind"_a = tremolo::name_of(found.kind), "frequency_hz"_a = found.point.omega / kTurn,
        "amplitude"_a = found.point.amplitude, "multiplier"_a = found.multiplier,
        "load_scale"_a = load_scale * found.point.load, "imperfect"_a = found.imperfect));
  return py::dict("frequency_hz"_a = frequencies, "amplitude"_a = amplitudes, "energy"_a = energies,
                  "stable"_a = stable, "harmonics"_a = harmonics, "share"_a = shares,
                  "load_scale"_a = loads, "motion"_a = motions, "bifurcations"_a = bifurcations,
                  "end"_a = tremolo::name_of(curve.end));
}

// A reduced force (r,), or zero for None.
Eigen::VectorXd force_of(py::handle given, const Model& model, const char* name) {
  if (given.is_none()) return Eigen::VectorXd::Zero(model.modes());
  return vector(given, model.modes(), name);
}

// The given load, or the default load for None, times its scale. Raises if it is zero.
Eigen::VectorXd load_of(py::handle load, double load_scale, const Model& model) {
  Eigen::VectorXd force = force_of(load, model, "load");
  if (load.is_none()) {
    if (model.default_load().vertices.empty())
      raise(
          usage_error("the model has no default load: name one with load=model.reduced_force("
                      "at, force)"));
    force = unwrap(reduce_load(model, model.default_load()));
  }
  if (!std::isfinite(load_scale) || force.isZero(0.0) || load_scale == 0.0)
    raise(content_error("the load must be finite and other than zero"));
  return load_scale * force;
}

// The load's course in time from a list of (number, scale) or (number, scale, degrees).
FourierSeries course_of(py::handle harmonics) {
  std::vector<LoadHarmonic> parts;
  if (!harmonics.is_none())
    for (const py::handle item : py::reinterpret_borrow<py::object>(harmonics)) {
      const auto values = py::cast<py::sequence>(item);
      if (values.size() != 2 && values.size() != 3)
        raise(usage_error("load_harmonics: a list of (number, scale) or (number, scale, degrees)"));
      const double degrees = values.size() == 3 ? values[2].cast<double>() : 0.0;
      parts.push_back({values[0].cast<int>(), values[1].cast<double>(), degrees * kTurn / 360.0});
    }
  return unwrap(load_course(parts));
}

// Runs trace() -> Result<MotionCurve> while other threads run. Raises.
template <class Trace>
MotionCurve traced(const Trace& trace) {
  Result<MotionCurve> curve = [&] {
    const py::gil_scoped_release unlocked;
    return trace();
  }();
  return unwrap(std::move(curve));
}

py::dict response(const PyModel& self, const std::pair<double, double>& frequencies,
                  py::handle load, double load_scale, py::handle load_harmonics, double alpha,
                  double beta, py::handle damping_ratio, py::handle constant, py::handle probe,
                  int harmonics, bool stability, py::handle folds_to) {
  const Model& model = *self.model;
  const VibratingSystem system = system_of(model, alpha, beta, damping_ratio);
  const FourierSeries course = course_of(load_harmonics);
  ResponseRequest request{load_of(load, load_scale, model) * course, kTurn * frequencies.first,
                          kTurn * frequencies.second};
  request.force.col(0) = force_of(constant, model, "constant");
  const double factor = folds_to.is_none() ? 1.0 : folds_to.cast<double>() / load_scale;
  if (!(factor > 0.0) || !std::isfinite(factor))
    raise(content_error("folds_to must be finite, not zero, and have the sign of load_scale"));
  const Probe seen = probe_of(probe, model, 0);
  CurveOptions options =
      options_of(harmonics, kMostHarmonicsOfResponse, stability, seen, extent_of(model));
  options.loaded_amplitude =
      loaded_amplitude_of(seen, probe_response_of(model, seen, load, load_scale, course));
  const MotionCurve curve = traced([&] { return response_curve(system, request, options); });
  py::dict result = dict_of(curve, system, load_scale);
  if (folds_to.is_none()) return result;
  py::list folds;
  for (const Bifurcation& at : curve.bifurcations) {
    if (at.kind != BifurcationKind::kFold) continue;
    py::dict fold =
        dict_of(traced([&] { return fold_curve(system, request, at.point, factor, options); }),
                system, load_scale);
    fold.attr("pop")("stable");
    folds.append(fold);
  }
  result["fold_curves"] = folds;
  return result;
}

void check_mode(int mode, const Model& model) {
  if (mode < 1 || mode > model.modes())
    raise(content_error("mode " + std::to_string(mode) + ": the model has modes 1 to " +
                        std::to_string(model.modes())));
}

py::dict backbone(const PyModel& self, int mode, double to_amplitude, py::handle constant,
                  py::handle probe, int harmonics, bool stability) {
  const Model& model = *self.model;
  check_mode(mode, model);
  const VibratingSystem system = system_of(model, 0.0, 0.0, py::none());
  const BackboneRequest request{mode - 1, force_of(constant, model, "constant"), to_amplitude};
  const CurveOptions options =
      options_of(harmonics, kMostHarmonicsOfBackbone, stability, probe_of(probe, model, mode - 1),
                 std::max(2.0 * to_amplitude, extent_of(model)));
  return dict_of(traced([&] { return backbone_curve(system, request, options); }), system, 0.0);
}

py::dict damped_backbone(const PyModel& self, int mode, double to_amplitude, py::handle load,
                         double load_scale, double alpha, double beta, py::handle damping_ratio,
                         py::handle constant, py::handle probe, int harmonics, bool stability) {
  const Model& model = *self.model;
  check_mode(mode, model);
  const VibratingSystem system = system_of(model, alpha, beta, damping_ratio);
  if (!system.damped())
    raise(content_error("a damped backbone needs a damping, such as damping_ratio=\"2%\""));
  const DampedBackboneRequest request{mode - 1, force_of(constant, model, "constant"),
                                      load_of(load, load_scale, model), to_amplitude};
  const Probe seen = probe_of(probe, model, mode - 1);
  CurveOptions options = options_of(harmonics, kMostHarmonicsOfBackbone, stability, seen,
                                    std::max(2.0 * to_amplitude, extent_of(model)));
  FourierSeries cosine = FourierSeries::Zero(1, 3);
  cosine(0, cosine_column(1)) = 1.0;
  options.loaded_amplitude =
      loaded_amplitude_of(seen, probe_response_of(model, seen, load, load_scale, cosine));
  return dict_of(traced([&] { return damped_backbone_curve(system, request, options); }), system,
                 load_scale);
}

}  // namespace

void add_curves(py::class_<PyModel, PyModelPointer>& model) {
  model.def(
      "response", &response, py::arg("frequencies"), py::kw_only(), py::arg("load") = py::none(),
      py::arg("load_scale") = 1.0, py::arg("load_harmonics") = py::none(), py::arg("alpha") = 0.0,
      py::arg("beta") = 0.0, py::arg("damping_ratio") = py::none(),
      py::arg("constant") = py::none(), py::arg("probe") = py::none(), py::arg("harmonics") = 5,
      py::arg("stability") = true, py::arg("folds_to") = py::none(),
      "The periodic motions under load_scale * load * sin(2 pi f t), f from the first to the "
      "second of `frequencies`, Hz, through folds, as `tremolo response` finds them. load: "
      "reduced, (r,), the default load if None; constant: a reduced force that stays, (r,). "
      "load_harmonics: a list of (number, scale) or (number, scale, degrees); the sum of "
      "scale * sin(number * 2 pi f t + degrees) replaces the sine. "
      "alpha (1/s), beta (s), or damping_ratio, such as \"2%\" or \"1:2%,30:5%\". probe: a "
      "vertex or a selector; by default what moves most in mode 1. Returns a dict of n "
      "points: frequency_hz, amplitude (of the probe, m, with the stored response to the default "
      "load), "
      "energy (J), stable, harmonics, "
      "share (of the two highest ones) and load_scale, each (n,); motion, a list of n arrays (r, 2 "
      "H + 1), "
      "columns c_0, a_1, b_1, ..., of c_0 + sum a_k cos k w t + b_k sin k w t; bifurcations, "
      "a list of dicts; end, why the curve ends: done, unbounded, returned, stuck, long, loop, or "
      "of "
      "backbones joined or coarse. A bifurcation is imperfect where the curve passes another one "
      "across a gap narrower than a step. "
      "With folds_to, a load_scale, each fold is followed over the load, and fold_curves is a list "
      "of such dicts, without stable; their bifurcations are cusps. "
      "Other threads run meanwhile; Ctrl-C ends it.");
  model.def("backbone", &backbone, py::arg("mode"), py::arg("to_amplitude"), py::kw_only(),
            py::arg("constant") = py::none(), py::arg("probe") = py::none(),
            py::arg("harmonics") = 5, py::arg("stability") = true,
            "The free periodic motions without damping (nonlinear normal modes) of mode 1, 2, ..., "
            "up to the amplitude of the probe, m, as `tremolo backbone` finds them. The dict is "
            "that of response; load_scale is 0.");
  model.def("damped_backbone", &damped_backbone, py::arg("mode"), py::arg("to_amplitude"),
            py::kw_only(), py::arg("load") = py::none(), py::arg("load_scale") = 1.0,
            py::arg("alpha") = 0.0, py::arg("beta") = 0.0, py::arg("damping_ratio") = py::none(),
            py::arg("constant") = py::none(), py::arg("probe") = py::none(),
            py::arg("harmonics") = 5, py::arg("stability") = true,
            "The damped motions in phase resonance of mode 1, 2, ..., up to the amplitude of the "
            "probe, m, as `tremolo backbone --damped` finds them: the displacement along the load "
            "lags load_scale * load * cos(2 pi f t) by 90 degrees. The dict is that of response; "
            "its load_scale is the load that keeps each motion.");
}

}  // namespace tremolo::python
