// The scenes of the bench: a model, a load, and the load's factor that makes the motion as large as
// asked for.
#pragma once

#include <string>

#include "tests/lab/bench/sampled_run.h"
#include "tests/lab/samples/sample_models.h"
#include "tests/lab/work/store.h"

namespace tremolo::bench {

using reproduce::SampleModel;

// size: largest extent of the surface's bounding box at rest, m. watched: rows of the first loaded
// vertex. force: of the default load, reduced. band: the high band begins where the default split
// of a step of 3 ms does.
struct Subject {
  SampleModel sample;
  double size = 0.0;
  Eigen::Matrix<double, 3, Eigen::Dynamic> watched;
  Eigen::VectorXd force;
  Eigen::Index band = 0;
};

// Throws a Failure where the vertex or the load cannot be read.
Subject make_subject(SampleModel sample);

// load: "square", "impulse" or "sine". amplitude: see Options. scale: of the default load; zero if
// none was found, `trouble` says why.
struct Scene {
  const Subject* subject = nullptr;
  std::string load;
  double amplitude = 0.0;
  double duration = 6.0;
  double scale = 0.0;
  std::string trouble;

  bool usable() const { return scale > 0.0; }
  std::string name() const;    // "horse-square-0.05"
  nlohmann::json key() const;  // all that its runs depend on but the method and its step
  RunSpec run(const std::string& integrator, double step) const;
};

// Sets scale or trouble. The largest displacement is within 1 % of the amplitude; the scale has
// four digits. Throws a Failure (kSystem) for the store.
void find_scale(Scene& scene, const Store& store);

}  // namespace tremolo::bench
