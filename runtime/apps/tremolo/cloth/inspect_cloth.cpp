#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/mesh/tet_mesh.h"
#include "runtime/apps/tremolo/cloth/cloth_commands.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/step/nodal_integrator.h"

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

BoundingBox box_of(const Eigen::VectorXd& positions) {
  std::vector<Eigen::Vector3d> points;
  for (Eigen::Index i = 0; i < positions.size(); i += 3)
    points.emplace_back(positions.segment<3>(i));
  return bounding_box(points);
}

// Balls that a particle is in, or nearer to than 1 % of the cloth's size.
Json contacts_of(const ClothFile& file, const ClothWorld& world) {
  Json contacts = Json::array();
  for (std::size_t i = 0; i < world.cloths(); ++i) {
    const Eigen::VectorXd& x = world.positions(i);
    const double size = box_of(x).diagonal();
    for (std::size_t b = 0; b < world.balls().size(); ++b) {
      const SceneBall& ball = file.scene.balls[b];
      const Eigen::Vector3d& centre = world.balls()[b].position;
      double distance = std::numeric_limits<double>::infinity();
      for (Eigen::Index p = 0; p < x.size(); p += 3)
        distance = std::min(distance, (x.segment<3>(p) - centre).norm() - ball.radius);
      if (distance < 0.01 * size)
        contacts.push_back({{"cloth", world.scene().cloths[i].name},
                            {"ball", ball.name},
                            {"distance_m", distance}});
    }
  }
  return contacts;
}

// The longest stable step of each method, s, the smallest over the cloths; methods without a limit
// are left out.
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
  for (std::size_t i = 0; i < world.cloths(); ++i) {
    Json cloth = cloth_contents(world.scene().cloths[i].name, world.model(i));
    const BoundingBox box = box_of(world.positions(i));
    cloth["low"] = vector_json(box.low);
    cloth["high"] = vector_json(box.high);
    json["cloths"].push_back(std::move(cloth));
  }
  json["places"] = Json::array();
  for (std::size_t b = 0; b < world.balls().size(); ++b)
    json["places"].push_back({{"ball", file.scene.balls[b].name},
                              {"position", vector_json(world.balls()[b].position)},
                              {"radius", file.scene.balls[b].radius}});
  json["contacts"] = contacts_of(file, world);
  json["stability_limits_s"] = step_limits(world);
  json["warnings"] = keyframe_warnings(file.scene);
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
  const auto text = [](const Json& x) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", x[0].get<double>(), x[1].get<double>(),
                       x[2].get<double>());
  };
  show("at t = 0:\n");
  for (const Json& cloth : json["cloths"])
    show("  {}: from {} to {} m\n", cloth["cloth"].get<std::string>(), text(cloth["low"]),
         text(cloth["high"]));
  for (const Json& ball : json["places"])
    show("  {}: at {}, radius {:.4g} m\n", ball["ball"].get<std::string>(), text(ball["position"]),
         ball["radius"].get<double>());
  for (const Json& contact : json["contacts"])
    show("  {} is {:.4g} m from {}\n", contact["cloth"].get<std::string>(),
         contact["distance_m"].get<double>(), contact["ball"].get<std::string>());
  for (const auto& [name, limit] : json["stability_limits_s"].items())
    show("  {} is stable up to steps of {:.4g} s\n", name, limit.get<double>());
}

}  // namespace

int inspect_cloth_command(const ClothFile& file, bool json) {
  // Implicit Euler has no stability limit: a method beyond its limit is reported, not refused.
  ClothScene scene = file.scene;
  scene.integrator = "implicit-euler";
  const Result<ClothWorld> world = ClothWorld::create(scene);
  if (!world) return report_error(error_of_file(file.path, value_error(world.error())));
  const Json contents = scene_contents(file, *world);
  print_warnings(keyframe_warnings(file.scene));
  if (json)
    print_json(contents);
  else
    print_contents(contents);
  return flushed(0);
}

Warnings keyframe_warnings(const ClothScene& scene) {
  Warnings warnings = keyframe_warnings({}, scene.colliders);
  for (const SceneBall& ball : scene.balls)
    warn_away("ball '" + ball.name + "'", ball.motion, Pose{ball.position}, warnings);
  return warnings;
}

}  // namespace tremolo
