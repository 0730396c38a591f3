// One body from its start to the end of its time, watched.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/tremolo/run/body_report.h"
#include "runtime/apps/tremolo/run/run_body.h"
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

// The report of a body that runs by itself. Energies in J; not-a-number: not known.
struct RunReport : BodyReport {
  double step = 0;                   // s
  double duration = 0;               // s
  double first_frequency = 0;        // of the first mode, Hz
  double scale = 1;                  // of the load: as given, or found by --deflect
  double microseconds_per_step = 0;  // processor time of step(), without measurements
  double energy_put_in = 0;          // at the start and by the load, the largest sum, J
  double energy_reference = 0;       // after the end of the load; at the end of the run if it lasts
  double energy_drift_max = 0;       // docs/reference.md
  double largest_probe = 0;          // largest displacement of the first probe, m
  std::string sound_warning;         // of --wav; empty: none
  std::vector<SplitMove> moves;      // all changes of the split
  StretchRange stretch;              // of the surface, the widest in all samples
  double squeezed_at = -1;           // s; first of them with a stretch below kSofteningStretch
  std::optional<RigidLoss> rigid;    // of a free body with a load
};

// Runs one body. With --deflect the load's factor is found first, by runs that write nothing.
// Errors: those of loading, creating and writing; kContent if no factor gives the deflection. A run
// that ends early gives a report, not an error. SIGINT, SIGTERM and SIGHUP end it early, with all
// results up to then.
// threads: as for begin_run().
Result<RunReport> simulate(const BodyScene& scene, unsigned threads = 1);

// `tremolo run`. Runs every body of the list. threads: that step it, 0: one per core. json: one
// object on stdout, also when a run failed. The exit code; errors are printed on stderr.
int run_command(const std::vector<BodyScene>& bodies, unsigned threads, bool json);

}  // namespace tremolo
