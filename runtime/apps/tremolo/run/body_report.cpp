#include "runtime/apps/tremolo/run/body_report.h"

#include "runtime/apps/tremolo/output/text_values.h"

namespace tremolo {

using Json = nlohmann::ordered_json;

void BodyReport::take_end(const Moment& last) {
  steps = last.steps;
  reached = last.time;
  iterations = last.iterations;
  halved_steps = last.halved_steps;
  work = last.work;
  dissipated = last.dissipated;
  split = last.split;
}

void add_body(const BodyReport& report, Json& json) {
  json["body"] = report.name;
  json["model"] = report.model;
  json["integrator"] = report.integrator;
  json["steps"] = report.steps;
  json["reached"] = report.reached;
  json["iterations_per_step"] = number_or_null(report.iterations_per_step());
  json["halved_steps"] = report.halved_steps;
  json["energy_initial"] = number_or_null(report.energy_initial);
  json["energy_final"] = number_or_null(report.energy_final);
  json["high_band_final"] = number_or_null(report.high_band_final);
  json["work"] = number_or_null(report.work);
  json["dissipated"] = number_or_null(report.dissipated);
  json["low_modes"] = report.split ? Json(report.split->low) : Json(nullptr);
  json["high_modes"] = report.split ? Json(report.split->high) : Json(nullptr);
  json["size"] = number_or_null(report.size);
  json["largest_displacement"] = number_or_null(report.farthest.distance);
  json["largest_displacement_share"] = number_or_null(report.farthest.distance / report.size);
  json["largest_displacement_vertex"] = report.farthest.vertex;
  json["largest_displacement_at"] = number_or_null(report.farthest_at);
}

void add_ending(const BodyReport& report, Json& json) {
  add_ending(static_cast<const RunEnding&>(report), json);
  json["notes"] = report.notes;
  json["files"] = report.files;
}

}  // namespace tremolo
