#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/text.h"
#include "formats/basis/derived_basis.h"
#include "runtime/apps/tremolo/run/run_body.h"

namespace tremolo {
namespace {

struct NewMaterial {
  std::optional<double> young;    // Pa
  std::optional<double> density;  // kg/m^3
};

Result<NewMaterial> parse_rescale(const std::string& text) {
  NewMaterial material;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    const std::size_t equals = part.find('=');
    const std::string_view name = part.substr(0, equals);
    std::optional<double>* target = name == "young"     ? &material.young
                                    : name == "density" ? &material.density
                                                        : nullptr;
    double value = 0.0;
    const char* first = equals == std::string_view::npos ? part.data() : part.data() + equals + 1;
    const char* end = part.data() + part.size();
    const auto [stop, error] = read_decimal(first, end, value);
    if (target == nullptr || equals == std::string_view::npos || error != std::errc{} ||
        stop != end || *target)
      return usage_error("--rescale " + text +
                         ": expected young=PA, density=KG/M3 or both, as in young=2e5,density=500");
    if (!(value > 0.0) || !std::isfinite(value))
      return usage_error("--rescale " + text + ": a value must be positive and finite");
    *target = value;
  }
  if (!material.young && !material.density)
    return usage_error("--rescale: it is empty: expected young=PA, density=KG/M3 or both");
  return material;
}

// Parses an untrusted text as JSON, unless it is nested deeply.
nlohmann::json parse_flat(const std::string& text) {
  bool deep = false;
  nlohmann::json json = nlohmann::json::parse(
      text,
      [&deep](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
        deep = deep || depth > 64;
        return !deep;
      },
      false);
  return deep ? nlohmann::json() : json;
}

std::optional<double> number_of(const nlohmann::json& material, const char* key) {
  if (!material.is_object() || !material.contains(key) || !material[key].is_number())
    return std::nullopt;
  const double value = material[key].get<double>();
  return value > 0.0 && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

Result<BasisData> rescale_model(BasisData data, const std::string& text, const std::string& path) {
  const Result<NewMaterial> wanted = parse_rescale(text);
  if (!wanted) return wanted.error();
  const auto refuse = [&](const std::string& why) {
    return content_error(path + ": --rescale " + text + ": " + why);
  };
  nlohmann::json maker = parse_flat(data.provenance);
  if (maker.is_object() && maker.contains("materials"))
    return refuse(
        "the model has several materials, whose stiffness and mass do not change together: make it "
        "again with tremolo-precompute");
  if (!maker.is_object() || !maker.contains("material"))
    return refuse("the file does not say of which material it is");
  if (wanted->density && maker.contains("point_masses"))
    return refuse("the model has point masses, which do not change with the density");
  nlohmann::json& material = maker["material"];
  const auto factor = [&](const std::optional<double>& value, const char* key) {
    const auto old = number_of(material, key);
    if (!value) return std::optional(1.0);
    return old ? std::optional(*value / *old) : std::nullopt;
  };
  const auto stiffness = factor(wanted->young, "young_pa");
  const auto density = factor(wanted->density, "density_kg_m3");
  if (!stiffness)
    return refuse("its material is orthotropic or not known: it has no one Young's modulus");
  if (!density) return refuse("its density is not known");
  Result<BasisData> made = rescaled(std::move(data), *stiffness, *density);
  if (!made) return refuse(made.error().message);
  if (wanted->young) material["young_pa"] = *wanted->young;
  if (wanted->density) material["density_kg_m3"] = *wanted->density;
  maker["rescaled"] = text;
  made->provenance = maker.dump();
  return made;
}

}  // namespace tremolo
