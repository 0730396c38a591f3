#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/apps/tremolo/run/run_options.h"

namespace tremolo {
namespace {

void add_load_flags(CLI::App& run, RunOptions& o) {
  CLI::Option* load = run.add_option("--load", o.load,
                                     "impulse (3 ms), square (0.3 s), sine (1 Hz), chirp, ramp, "
                                     "constant, none")
                          ->capture_default_str();
  run.add_option("--frequency", o.shape.frequency, "of --load sine, Hz");
  run.add_option("--sweep", o.shape.sweep,
                 "F1,F2: the frequencies between which --load chirp moves, Hz (1,10)");
  run.add_option(
      "--load-duration", o.shape.duration,
      "how long the load lasts, s; of a ramp, its rise; of a chirp, the sweep (both: the "
      "whole run)");
  run.add_option("--signal", o.signal,
                 "CSV of times (s) and values: the load's course in time instead, straight lines "
                 "between")
      ->excludes(load);
  add_force_flags(run, o);
  CLI::Option* scale =
      run.add_option("--scale", o.scale, "multiplies the load")->capture_default_str();
  run.add_option("--deflect", o.deflect,
                 "5%: scale the load until the largest displacement of the run is this share of "
                 "the size")
      ->excludes(scale);
  run.add_option(
      "--start", o.start,
      "static (standing still under the load at t = 0), VERTEX|SELECTOR=X,Y,Z (displaced "
      "by that vector, m, and released), or FILE.csv[@T] (a row of a run with --coordinate all "
      "--velocities)");
}

}  // namespace

void add_modes_flag(CLI::App& app, LoadedModelOptions& o) {
  app.add_option("--modes", o.modes, "keep the first R coordinates only (0: all)");
}

void add_material_flags(CLI::App& app, LoadedModelOptions& o) {
  app.add_option("--rescale", o.rescale,
                 "young=PA,density=KG/M3, one or both: the model as if made of this; exact for one "
                 "material");
  app.add_flag("--linear", o.linear, "leave the cubic and quartic terms out: not read, not kept");
}

void add_damping_flags(CLI::App& app, LoadedModelOptions& o) {
  CLI::Option* alpha = app.add_option("--alpha", o.alpha, "Rayleigh damping of the mass, 1/s");
  CLI::Option* beta = app.add_option("--beta", o.beta, "Rayleigh damping of the rest stiffness, s");
  app.add_option("--damping-ratio", o.damping_ratio,
                 "fraction of critical damping: 2% of every mode, 2%,1%,0.5% of each, 1:2%,30:5% "
                 "Rayleigh damping by two frequencies (Hz), 1:2%,10:1%,30:5% a table")
      ->excludes(alpha)
      ->excludes(beta);
}

void add_force_flags(CLI::App& app, LoadedModelOptions& o) {
  app.add_option("--at", o.at,
                 "what the load acts on, a vertex's id or a selector (default: the model's)");
  app.add_option("--force", o.force,
                 "with --at: X,Y,Z in N, shared by the vertices, on a face by area");
}

void add_body_flags(CLI::App& run, RunOptions& o) {
  run.add_option("--integrator", o.integrator,
                 fmt::format("{}", fmt::join(integrator_names(), ", ")))
      ->capture_default_str();
  run.add_option("--step", o.step, "h, s")->capture_default_str();
  add_material_flags(run, o);
  add_damping_flags(run, o);
  run.add_option("--newmark-beta", o.newmark_beta, "Newmark's beta")->capture_default_str();
  run.add_option("--newmark-gamma", o.newmark_gamma, "Newmark's gamma")->capture_default_str();
  run.add_option("--split", o.split, "which coordinates are explicit: default, thesis or a count")
      ->capture_default_str();
  run.add_option("--safety", o.safety, "of the default split: explicit iff h w < 2 safety")
      ->capture_default_str();
  run.add_option("--tolerance", o.tolerance, "of a step's solve, relative")->capture_default_str();
  run.add_option("--max-iterations", o.max_iterations, "of a step's solve")->capture_default_str();
  run.add_flag("--hull", o.hull, "show the boundary of the tetrahedra, not the render surface");
  add_load_flags(run, o);
}

}  // namespace tremolo
