// The error of an implicit solve must not show in the energy: on the sample models, at the default
// tolerance, a smaller step drifts less.
#include <gtest/gtest.h>

#include "tests/lab/bench/sampled_run.h"
#include "tests/lab/samples/sample_models.h"

namespace tremolo {
namespace {

constexpr double kRounding = 1e-13;  // ten times the error of the exact methods in these runs

double drift_of(const Model::Pointer& model, const char* method, double step) {
  bench::RunSpec spec;
  spec.model = model;
  spec.integrator = method;
  spec.options.step = step;
  const Result<Eigen::VectorXd> force = reduce_load(*model, model->default_load());
  EXPECT_TRUE(force);
  spec.load = {{.kind = SignalKind::kSquare}, *force};
  spec.duration = 3.0;
  const bench::SampledRun run = bench::run_sampled(spec);
  EXPECT_EQ(run.exit_code, 0) << method << " at " << step;
  return run.drift;
}

TEST(StepDrift, HalvingTheStepNeverWorsensTheDriftOfAnImplicitMethod) {
  for (const auto& sample : reproduce::load_sample_models(TREMOLO_MODEL_DIR, {"beam", "tower"}))
    for (const char* method : {"newmark", "midpoint", "implicit-euler", "imexv", "imexv-adaptive",
                               "imexv-coupled", "avf", "ep2", "ep4"}) {
      double before = drift_of(sample.model, method, 1.5e-3);
      for (const double step : {0.75e-3, 0.375e-3, 0.1875e-3}) {
        const double drift = drift_of(sample.model, method, step);
        EXPECT_LE(drift, std::max(before, kRounding))
            << sample.name << ", " << method << ", " << step;
        before = drift;
      }
    }
}

}  // namespace
}  // namespace tremolo
