#include "runtime/program/cloth/inspect_cloth.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "runtime/cloth/cloth_model.h"
#include "runtime/cloth/cloth_stability.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/nodal/nodal_integrator.h"
#include "runtime/program/output/json_values.h"
#include "runtime/program/output/tell.h"
#include "runtime/program/run/run_body.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json cloth_contents(const std::string& name, const ClothModel& model) {
  const double omega =
      std::sqrt(largest_eigenvalue(model, model.parts().x, ForcePart::kAll));  // 1/s
  const auto held = model.held();
  return {{"cloth", name},
          {"particles", model.size()},
          {"held", held.size() - static_cast<std::size_t>(std::ranges::count(held, 0))},
          {"triangles", model.parts().triangles.size()},
          {"structural", model.structural().size()},
          {"shear", model.shear().size()},
          {"bend", model.bend().size()},
          {"mass_kg", model.mass().sum()},
          {"frequency_max_hz", number_or_null(omega / (2.0 * std::numbers::pi))}};
}

// The smallest over the cloths of what each method stands, s; methods without a limit are left out.
Json step_limits(const ClothWorld& world) {
  Json limits = Json::object();
  for (const std::string_view name : nodal_integrator_names()) {
    double limit = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < world.cloths(); ++i)
      limit = std::min(limit, stable_step(name, world.model(i), world.positions(i)));
    if (std::isfinite(limit)) limits[std::string(name)] = limit;
  }
  return limits;
}

Json scene_contents(const ClothFile& file, const ClothWorld& world) {
  Json json = {{"scene", file.path},
               {"integrator", file.scene.integrator},
               {"step", file.scene.options.step},
               {"duration", file.scene.duration},
               {"balls", file.scene.balls.size()},
               {"colliders", file.scene.colliders.size()},
               {"cloths", Json::array()}};
  for (std::size_t i = 0; i < world.cloths(); ++i)
    json["cloths"].push_back(cloth_contents(world.scene().cloths[i].name, world.model(i)));
  json["stability_limits_s"] = step_limits(world);
  return json;
}

void print_contents(const Json& json) {
  show("{}: {} in steps of {:.4g} s for {:.6g} s, balls: {}, colliders: {}\n",
       json["scene"].get<std::string>(), json["integrator"].get<std::string>(),
       json["step"].get<double>(), json["duration"].get<double>(), json["balls"].get<std::size_t>(),
       json["colliders"].get<std::size_t>());
  for (const Json& cloth : json["cloths"]) {
    const auto number = [&](const char* key) { return cloth[key].get<std::size_t>(); };
    show("  {}: {} particles, {} of them held, {} triangles, {:.6g} kg\n",
         cloth["cloth"].get<std::string>(), number("particles"), number("held"),
         number("triangles"), cloth["mass_kg"].get<double>());
    show("    springs: structural {}, shear {}, bend {}\n", number("structural"), number("shear"),
         number("bend"));
    if (cloth["frequency_max_hz"].is_number())
      show("    fastest oscillation {:.6g} Hz\n", cloth["frequency_max_hz"].get<double>());
  }
  for (const auto& [name, limit] : json["stability_limits_s"].items())
    show("  {} is stable up to steps of {:.4g} s\n", name, limit.get<double>());
}

}  // namespace

int inspect_cloth_command(const ClothFile& file, bool json) {
  // A method beyond its limit would be refused, which is to be told here.
  ClothScene scene = file.scene;
  scene.integrator = "implicit-euler";
  const Result<ClothWorld> world = ClothWorld::create(scene);
  if (!world) return report_error(error_of_file(file.path, value_error(world.error())));
  const Json contents = scene_contents(file, *world);
  if (json)
    print_json(contents);
  else
    print_contents(contents);
  return flushed(0);
}

}  // namespace tremolo
