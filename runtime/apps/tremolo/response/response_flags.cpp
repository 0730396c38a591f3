#include <CLI/CLI.hpp>

#include "runtime/apps/tremolo/response/response_commands.h"

namespace tremolo {
namespace {

void add_common_flags(CLI::App& app, PeriodicOptions& o) {
  app.add_option("file", o.model, "basis file")->required();
  add_modes_flag(app, o);
  add_material_flags(app, o);
  app.add_option("--static-scale", o.static_scale,
                 "the load also acts constantly, times this factor")
      ->capture_default_str();
  app.add_option("--gravity", o.gravity, "X,Y,Z: the acceleration of gravity, m/s^2");
  app.add_option("--harmonics", o.harmonics, "harmonics of the motion at the start")
      ->capture_default_str();
  app.add_option("--most-harmonics", o.most_harmonics,
                 "harmonics are added up to this number (default: 25 of a response, 15 of a "
                 "backbone)");
  app.add_option("--harmonic-share", o.harmonic_share,
                 "harmonics are added where the two highest hold more than this share")
      ->capture_default_str();
  app.add_option("--longest-step", o.longest_step,
                 "the largest change of the motion between two points, relative to it")
      ->capture_default_str();
  app.add_option("--most-points", o.most_points, "a curve ends after so many points")
      ->capture_default_str();
  app.add_flag("--no-stability", o.no_stability, "compute no stability and no bifurcations");
  app.add_option("--probe", o.probe,
                 "the vertex whose amplitude is reported; of a selector, the one that moves most "
                 "(default: the vertex that moves most in the mode)");
  app.add_option("--csv", o.csv, "write the points as a table, .csv");
  app.add_option("--page", o.page, "draw the curves on a page, .html; it needs no other file");
  app.add_option("--out", o.out, "directory for all three: table, page and JSON");
  app.add_option("--orbit", o.orbit_files,
                 "write a period of one motion for other programs: .glb, .usda, .pvd, .pc2, .mdd, "
                 "surfaces as .ply or .obj, or .html; may be repeated");
  app.add_option("--orbit-at", o.orbit_at,
                 "which motion of the first curve: peak, last, a frequency as in 1.2Hz, or an "
                 "amplitude as in 8% of the size or 0.02m")
      ->capture_default_str();
  app.add_option("--orbit-frames", o.orbit_frames, "frames of the period")->capture_default_str();
  app.add_option("--orbit-seconds", o.orbit_seconds,
                 "seconds that the period lasts in the files (0: as long as it is)")
      ->capture_default_str();
  app.add_flag("--json", o.json, "print one JSON object on stdout");
}

}  // namespace

void add_response_flags(CLI::App& app, ResponseOptions& o) {
  add_common_flags(app, o);
  add_force_flags(app, o);
  app.add_option("--load-scale", o.load_scales,
                 "multiplies the load; several, as in 1,2,5, give a curve each")
      ->capture_default_str();
  app.add_option("--load-harmonic", o.load_harmonics,
                 "K:SCALE[:DEGREES]: the load has SCALE sin(2 pi K f t + DEGREES); may be repeated "
                 "(default: 1:1)");
  add_damping_flags(app, o);
  app.add_option("--from", o.from, "the first frequency, Hz")->required();
  app.add_option("--to", o.to, "the last frequency, Hz; may be lower")->required();
  app.add_option("--folds-to", o.folds_to,
                 "also follow the folds of the first curve while the load changes to this scale");
  app.add_flag("--by-stepping", o.by_stepping,
               "also find the stable points by time stepping, and print what both cost");
  app.add_flag("--branches", o.branches,
               "also follow the branches that cross the first curve at its branch points");
}

void add_backbone_flags(CLI::App& app, BackboneOptions& o) {
  add_common_flags(app, o);
  add_force_flags(app, o);
  add_damping_flags(app, o);
  app.add_flag("--damped", o.damped,
               "the motions that the load keeps in phase resonance against the damping: the ridge "
               "of the response curves, with the load that each needs");
  app.add_option("--mode", o.mode, "the mode of small vibration that it begins with, from 1")
      ->capture_default_str();
  app.add_option("--to-amplitude", o.to_amplitude,
                 "the largest displacement at the end: a share of the size as in 10% or 0.1, or a "
                 "length as in 0.02m")
      ->capture_default_str();
}

}  // namespace tremolo
