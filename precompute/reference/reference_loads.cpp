#include "precompute/reference/reference_loads.h"

#include "precompute/system/failure.h"

namespace tremolo {

Vector BodyLoads::mean(double time, double step) const {
  return mean_load(shape, time, step) * point + gravity;
}

bool BodyLoads::to_come(double time, double step) const {
  return !gravity.isZero(0.0) || time < load_end(shape) - 1e-9 * step;
}

BodyLoads make_body_loads(const ReferenceOptions& options, const Problem& problem,
                          const FullOrder& body) {
  BodyLoads loads;
  loads.shape = unwrap(parse_load_shape(options.load.value_or("impulse")));
  const Vector point = options.scale * point_load(body, problem.load);
  loads.point = deforming_load(body, point);
  loads.gravity = deforming_load(body, gravity_load(body, options.gravity));
  if (problem.load.vertices.empty()) {
    if (options.load && loads.shape != LoadShape::kNone)
      throw Failure({ErrorKind::kUsage,
                     "--load needs to know where: name it with --load-at and --load-force"});
    loads.shape = LoadShape::kNone;
  } else if (options.scale != 0 && point.isZero(0.0)) {
    throw Failure(content_error("--load-at: the force acts along held components only"));
  }
  const bool pushed = loads.shape != LoadShape::kNone && !point.isZero(0.0);
  if (!pushed) loads.point.setZero();
  if (!loads.point.isZero(0.0) || !loads.gravity.isZero(0.0)) return loads;
  if (problem.free_body && (pushed || !options.gravity.isZero(0.0)))
    throw Failure(content_error("the load moves the free body as a whole and deforms nothing"));
  throw Failure(
      {ErrorKind::kUsage, "nothing loads the body: use --load-at with --load-force, or --gravity"});
}

}  // namespace tremolo
