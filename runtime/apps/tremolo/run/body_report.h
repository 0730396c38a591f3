// The measurements of one reduced body in a run, by itself or in a scene, and their JSON.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/stretch.h"
#include "runtime/apps/tremolo/run/recorder.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/body.h"

namespace tremolo {

struct BodyReport : RunEnding {
  std::string name;
  std::string model;       // path; of a rigid body its shape or mesh
  std::string integrator;  // its name
  std::int64_t steps = 0;  // that succeeded
  double reached = 0.0;    // s of simulated time
  std::int64_t iterations = 0;
  std::int64_t halved_steps = 0;   // steps that were subdivided because their solve failed
  double energy_initial = 0.0;     // J
  double energy_final = 0.0;       // J
  double high_band_final = 0.0;    // J
  double work = 0.0;               // J, on the body
  double dissipated = 0.0;         // J
  std::optional<Split> split;      // at the end, of a splitting method
  double size = 0.0;               // the largest extent of the surface at rest, m
  Excursion farthest;              // of the surface's vertices in the body's frame, in all samples
  double farthest_at = 0.0;        // s
  std::vector<std::string> notes;  // start/run_notes.h
  std::vector<std::string> files;  // written, in the body's folder

  double iterations_per_step() const {
    return static_cast<double>(iterations) / static_cast<double>(std::max<std::int64_t>(steps, 1));
  }
  // Takes the counts and sums at the end of the run.
  void take_end(const Moment& last);
  void note_farthest(const Excursion& now, double time) {
    if (!(now.distance > farthest.distance)) return;
    farthest = now;
    farthest_at = time;
  }
};

// Adds the keys that all bodies have. Call add_ending() after the body's other keys.
void add_body(const BodyReport& report, nlohmann::ordered_json& json);
// Adds exit_code, reason, notes and files.
void add_ending(const BodyReport& report, nlohmann::ordered_json& json);

}  // namespace tremolo
