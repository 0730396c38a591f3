// Run time against error: the measurements and quantities computed from them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/lab/bench/measure.h"
#include "tests/lab/bench/options.h"

namespace tremolo::bench {

// entries: for each usable scene with a reference, each integrator, each step (from long to short),
// in that order. references: one per scene.
struct Precision {
  std::vector<Subject> subjects;
  std::vector<Scene> scenes;
  std::vector<Reference> references;
  std::vector<std::string> integrators;
  std::vector<double> steps;  // s
  std::vector<Entry> entries;

  bool measured(std::size_t scene) const {
    return scenes[scene].usable() && references[scene].trouble.empty();
  }
  // The entries of one curve, one per step; empty if the scene was not measured.
  std::span<const Entry> curve(std::size_t scene, const std::string& integrator) const;
};

// Measures, or fetches from the store, and says on stderr how far it is. Nothing but the times
// depends on the number of threads. Throws a Failure as the pieces do.
Precision measure_precision(const Options& options, std::vector<SampleModel> models,
                            const Store& store);

// The cost of a method (Entry::cost) at a given error, by log-log interpolation between the two
// steps where its error falls below. An error below the reference counts as kAbove times the gap.
// at_most: the longest step is already good enough, a longer one might be cheaper. Empty if the
// error is not reached or was not timed.
struct Cost {
  double value = 0.0;
  bool at_most = false;
};
std::optional<Cost> cost_of_error(std::span<const Entry> curve, double target, double gap);

// cost(other) / cost(method) in every measured scene: infinite where only the method reaches the
// target, zero where only the other does, left out where none does.
std::vector<double> cost_ratios(const Precision& precision, const std::string& method,
                                const std::string& other, double target);

// A method's rank at one target. slowdown: median, over the scenes it reaches, of its cost over
// that of the best. wins: scenes where it is the best.
struct Standing {
  std::string integrator;
  std::size_t reached = 0;
  std::size_t scenes = 0;
  std::size_t wins = 0;
  double slowdown = 0.0;
};

// Best first: those that reach the target in more scenes, then the faster ones.
std::vector<Standing> standings(const Precision& precision, double target);

}  // namespace tremolo::bench
