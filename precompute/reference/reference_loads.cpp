#include "precompute/reference/reference_loads.h"

#include "precompute/system/failure.h"

namespace tremolo {

Vector BodyLoads::mean(double time, double step) const {
  return sample_signal(signal, time, step).average * point + gravity;
}

double BodyLoads::share_at(double time, double step) const {
  return time > 0.0 ? sample_signal(signal, time - step, step).end : 0.0;
}

bool BodyLoads::to_come(double time, double step) const {
  return !gravity.isZero(0.0) || time < signal_end(signal) - 1e-9 * step;
}

BodyLoads make_body_loads(const ReferenceOptions& options, const Problem& problem,
                          const FullOrder& body) {
  BodyLoads loads;
  loads.signal = unwrap(parse_signal(options.load.value_or("impulse")));
  const Vector point = options.scale * point_load(body, problem.load);
  loads.point = deforming_load(body, point);
  loads.gravity = deforming_load(body, gravity_load(body, options.gravity));
  if (problem.load.vertices.empty()) {
    if (options.load && loads.signal.kind != SignalKind::kNone)
      throw Failure(
          {ErrorKind::kUsage, "--load needs a default load: give --load-at and --load-force"});
    loads.signal = {};
  } else if (options.scale != 0 && point.isZero(0.0)) {
    throw Failure(content_error("--load-at: the force acts along held components only"));
  }
  const bool pushed = loads.signal.kind != SignalKind::kNone && !point.isZero(0.0);
  if (!pushed) loads.point.setZero();
  if (!loads.point.isZero(0.0) || !loads.gravity.isZero(0.0)) return loads;
  if (problem.free_body && (pushed || !options.gravity.isZero(0.0)))
    throw Failure(content_error("the load moves the free body as a whole and deforms nothing"));
  throw Failure(
      {ErrorKind::kUsage, "nothing loads the body: use --load-at with --load-force, or --gravity"});
}

}  // namespace tremolo
