// Measurements and output files of a run of a world for one body.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/apps/tremolo/measure/energy_balance.h"
#include "runtime/apps/tremolo/output/stretch.h"
#include "runtime/apps/tremolo/run/body_files.h"
#include "runtime/apps/tremolo/run/body_report.h"
#include "runtime/apps/tremolo/world/surface_depth.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Limit for the energy balance of a body that avf, ep2 or ep4 moves, relative to the larger of the
// body's largest energy and the sum of all energy exchanged; beyond it the run ends with exit code
// 5. The error of the methods is rounding, that of contact the tolerance of its solve, 1e-10 of the
// momenta in a step.
inline constexpr double kBalanceBound = 1e-6;

// Position and motion of a body as a whole. pose: of the mesh's frame.
struct BodyPlace {
  Pose pose;
  Momenta momenta;
};

// The report of a body in a scene. Energies in J.
struct SceneBodyReport : BodyReport {
  BodyPlace start, end;
  EnergyAccount account;                 // at the end
  EnergyBalance balance;                 // of T + V and the energy stored in contact
  std::int64_t contacts = 0;             // how often it began to touch something
  bool asleep = false;                   // at the end
  double begins_within = 0.0;            // of the margin of a collider, m
  std::int64_t friction_held_steps = 0;  // ContactRecord::held_steps
  // Of the body on each collider since the start, N s, world.
  std::vector<std::pair<std::string, Eigen::Vector3d>> collider_impulses;
  double penetration_max = 0.0;          // of the size
  double penetration_surface_max = 0.0;  // m, of the drawn surface, in all samples
  std::optional<double> rebound;         // surface_depth.h
  double slip_max = 0.0;                 // ContactAccount::slip of all steps, m
  // J; what contact and joints may leave of a body at rest by rounding of its positions. No smaller
  // energy or error is judged.
  double rounding = 0.0;
  // J; ContactRecord::rounding, the sum of all steps. No smaller error is judged.
  double rounding_of_springs = 0.0;
  double contact_speed_max = 0.0;  // m/s
  std::int64_t passed_through = 0;

  // |change of the energy - all energy exchanged| over the largest energy; 0 if nothing ever moved
  // but by rounding.
  double balance_error() const {
    return balance.energy_max > rounding ? balance.remainder_max / balance.energy_max : 0.0;
  }
};

// Checks that the models have the columns requested for their bodies; coordinates of rigid bodies
// are left out. Call it before anything is written. Errors: kUsage, also if coordinates are
// requested of rigid bodies alone; kContent.
Status check_columns(const SceneWorld& world);

// Data shared by the logs of many bodies. looks: of a model; each body of it starts with a copy.
struct SharedLooks {
  std::map<const Model*, ShapeLooks> looks;
  NearBodies near;
};

class BodyLog {
 public:
  // Makes the body's folder, out/NAME, if there is an `out`. shared: data of all bodies' logs; it
  // must outlive them. Errors: kUsage and kContent for columns that the model does not have;
  // kSystem.
  static Result<BodyLog> create(const SceneFile& file, const SceneWorld& world, std::size_t body,
                                SharedLooks& shared);

  // Takes the start and then every step. The report says whether the orbit has left its energy
  // bound.
  Status observe(const SceneWorld& world);
  void give_up(const StepReport& step, double time) { report_.give_up(step, time); }
  // Renames the files from their temporary names.
  Status finish(const SceneWorld& world);

  void add_notes(const std::vector<std::string>& notes) { report_.notes = notes; }

  const SceneBodyReport& report() const { return report_; }
  const std::string& folder() const { return files_.folder(); }  // of the body; empty: none

 private:
  BodyLog(std::size_t body, BodyFiles files, const ShapeLooks& looks, SharedLooks& shared);
  void note_shape(const SceneWorld& world);
  void note_depth(const SceneWorld& world);
  void judge_balance();

  std::size_t body_;
  BodyFiles files_;
  ShapeLooks shape_looks_;
  double deepest_ = 0.0;  // of the points when the surface was measured, a share of the size
  Moment moment_;
  std::vector<double> further_;
  SceneBodyReport report_;
  SurfaceDepth depth_;
  SharedLooks* shared_;
  Rebound rebound_;
};

}  // namespace tremolo
