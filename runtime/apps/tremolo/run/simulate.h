// One body from its start to the end of its time, watched.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/stretch.h"
#include "runtime/body.h"
#include "runtime/model.h"

namespace tremolo {

// The rigid motion of a free body under a load. The mass is assumed to be uniform over the body.
struct RigidLoss {
  std::uint64_t rigid_modes = 0;  // motions left out of the model; six for a body in one piece
  // Fraction of the kinetic energy of a short push that goes into rigid motion, 0 to 1; the rest
  // goes into the model's coordinates. Not a number for several pieces.
  double share = 0.0;
  double force = 0.0;   // resultant of the load, N
  double torque = 0.0;  // about the centre of mass, N m
};

// Empty if the body is not free or there is no load. Errors: those of reading the file.
Result<std::optional<RigidLoss>> rigid_loss(const RunInput& input);

// The same for a given load, mass (kg) and number of rigid motions.
RigidLoss rigid_loss(const Model& model, const DefaultLoad& load, double mass,
                     std::uint64_t rigid_modes);

// As load_body(), with the step that --wav needs and the factor of the load that --deflect asks
// for. Errors: kUsage, kContent and kSystem as in simulate().
Result<RunInput> prepare_run(const BodyScene& scene);

// A change of a splitting method's split, before the step that began at `time`.
struct SplitMove {
  double time = 0;  // s
  Eigen::Index low_before = 0;
  Eigen::Index low_after = 0;
};

// End and measurements of a run. Energies in J; not-a-number: not known.
struct RunReport {
  std::string name;
  std::string integrator;
  double step = 0;
  double duration = 0;
  double first_frequency = 0;  // of the first mode, Hz
  double scale = 1;            // of the load: as given, or found by --deflect
  std::int64_t steps = 0;      // made
  double reached = 0;          // s of simulated time
  double iterations_per_step = 0;
  double microseconds_per_step = 0;  // processor time of step(), without measurements
  double energy_initial = 0;
  double energy_reference = 0;  // after the end of the load; at the end of the run if it lasts
  double energy_final = 0;
  double energy_drift_max = 0;  // docs/reference.md
  double high_band_final = 0;
  double work = 0;
  double dissipated = 0;
  double largest_probe = 0;        // largest displacement of the first probe, m
  std::string sound_warning;       // of --wav; empty: none
  std::optional<Split> split;      // at the end
  std::vector<SplitMove> moves;    // all changes of it
  std::int64_t halved_steps = 0;   // steps that were subdivided because their solve failed
  StretchRange stretch;            // of the surface, the widest in all samples
  double squeezed_at = -1;         // s; first of them with a stretch below kSofteningStretch
  double size = 0;                 // largest extent of the surface at rest, m
  Excursion farthest;              // of the surface in all samples
  double farthest_at = 0;          // s
  std::optional<RigidLoss> rigid;  // of a free body with a load
  std::vector<std::string> files;  // written, in the run's folder
  int exit_code = 0;               // 0, 4 or 5; 128 + n when signal n ended it early
  int signal = 0;                  // that n; 0: none
  std::string reason;              // why exit_code is not 0
  std::vector<std::string> notes;  // start/run_notes.h
};

// Runs one body. With --deflect the load's factor is found first, by runs that write nothing.
// Errors: those of loading, creating and writing; kContent if no factor gives the deflection. A run
// that ends early gives a report, not an error. SIGINT, SIGTERM and SIGHUP end it early, with all
// results up to then.
Result<RunReport> simulate(const BodyScene& scene);

// `tremolo run`. Runs every body of the list. json: one object on stdout, also when a run failed.
// The exit code; errors are printed on stderr.
int run_command(const std::vector<BodyScene>& bodies, bool json);

}  // namespace tremolo
