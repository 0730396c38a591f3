#include "formats/vega/veg_regions.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "formats/file/scanner.h"

namespace tremolo {
namespace {

// Without a name the tetrahedra would be of no region, and get the default material unseen.
std::string name_of(const FileMaterial& material) {
  return material.region.empty() ? "(unnamed)" : material.region;
}

}  // namespace

void set_veg_regions(const VegRegions& file, MeshBuilder& builder) {
  constexpr const char* kAll = "allElements";
  std::map<std::string_view, std::size_t> material_of_name;
  for (std::size_t i = 0; i < file.materials.size(); ++i)
    if (material_of_name.try_emplace(file.materials[i].region, i).second) {
      FileMaterial material = file.materials[i];
      material.region = name_of(material);
      builder.add_material(std::move(material));
    }
  std::vector<std::int64_t> material_of(builder.mesh().tetrahedra.size(), -1);
  // Backwards, with only the last of several regions of one set: the work is bounded by the file.
  std::set<std::string_view> done;
  std::vector<bool> shared(material_of.size(), false);
  std::size_t unknown = 0;
  for (auto region = file.regions.rbegin(); region != file.regions.rend(); ++region) {
    const auto& [set, material] = *region;
    const auto found = material_of_name.find(material);
    const auto elements = file.sets.find(set);
    if (found == material_of_name.end() || (elements == file.sets.end() && set != kAll)) {
      ++unknown;
      continue;
    }
    if (!done.insert(set).second) continue;
    const auto put = [&, label = std::int64_t(found->second)](std::size_t element) {
      if (material_of[element] < 0)
        material_of[element] = label;
      else if (material_of[element] != label)
        shared[element] = true;
    };
    if (elements == file.sets.end())
      for (std::size_t element = 0; element < material_of.size(); ++element) put(element);
    else
      for (std::int32_t element : elements->second) put(element);
  }
  if (unknown > 0)
    builder.add_note(std::to_string(unknown) +
                     " regions name a set or a material that the file does not have");
  const auto several = std::count(shared.begin(), shared.end(), true);
  if (several > 0)
    builder.add_note(std::to_string(several) +
                     " tetrahedra are in several regions: the last decides");
  builder.set_regions(material_of, [&file](std::int64_t label) {
    return label < 0 ? std::string() : name_of(file.materials[label]);
  });
}

namespace {

// The numbers that a kind of orthotropic material has after density and E1, E2, E3.
struct OrthotropicKind {
  std::string_view name;
  std::size_t poisson;  // 3 or 1
  std::size_t shear;    // 3, 1 or 0
  bool axes;
};
constexpr OrthotropicKind kOrthotropic[] = {
    {"ORTHOTROPIC", 3, 3, true},       {"ORTHOTROPIC_N3G3R9", 3, 3, true},
    {"ORTHOTROPIC_N3G3", 3, 3, false}, {"ORTHOTROPIC_N1G1R9", 1, 1, true},
    {"ORTHOTROPIC_N1G1", 1, 1, false}, {"ORTHOTROPIC_N1R9", 1, 0, true},
    {"ORTHOTROPIC_N1", 1, 0, false},
};

Error wrong_count(std::string_view kind, std::size_t expected, std::size_t found) {
  return content_error("expected " + std::to_string(expected) + " numbers of a material " +
                       quoted_text(kind) + ", found " + std::to_string(found));
}

Status set_axes(std::span<const double> r, Eigen::Matrix3d& axes) {
  axes << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  if (!axes.allFinite())  // maxCoeff() passes over NaN
    return content_error("expected nine finite numbers of a rotation");
  // Files have few digits; a matrix with a larger error is not a rotation.
  constexpr double kDigits = 1e-4;
  const Eigen::Matrix3d gram = axes.transpose() * axes;
  if (!((gram - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kDigits))
    return content_error("expected a rotation in the last nine numbers of an orthotropic material");
  const Result<Eigen::Matrix3d> clean = material_axes(axes.col(0), axes.col(1));
  if (!clean) return clean.error();
  axes = *clean;
  return Success{};
}

Result<Material> orthotropic(const OrthotropicKind& kind, std::span<const double> numbers) {
  const std::size_t count = 4 + kind.poisson + kind.shear + (kind.axes ? 9 : 0);
  if (numbers.size() != count) return wrong_count(kind.name, count, numbers.size());
  Material material;
  material.density = numbers[0];
  OrthotropicElasticity elasticity;
  for (int i = 0; i < 3; ++i) {
    elasticity.young[i] = numbers[1 + i];
    if (!(elasticity.young[i] > 0)) return content_error("E1, E2 and E3 must be positive");
  }
  const std::span<const double> poisson = numbers.subspan(4, kind.poisson);
  const std::span<const double> shear = numbers.subspan(4 + kind.poisson, kind.shear);
  for (int i = 0; i < 3; ++i) {
    const std::size_t at = i;
    const double a = elasticity.young[i];
    const double b = elasticity.young[(i + 1) % 3];
    elasticity.poisson[i] = kind.poisson == 3 ? poisson[at] : poisson[0] * std::sqrt(a / b);
    const double g = shear.empty() ? 1.0 : shear[0];
    elasticity.shear[i] =
        kind.shear == 3 ? shear[at] : g * std::sqrt(a * b) / (2.0 * (1.0 + poisson[0]));
  }
  if (kind.axes) {
    const Status status = set_axes(numbers.last(9), elasticity.axes);
    if (!status) return status.error();
  }
  material.orthotropic = elasticity;
  return material;
}

}  // namespace

Result<Material> veg_material(std::string_view kind, std::span<const double> numbers) {
  Result<Material> material = Material{};
  if (kind == "ENU") {
    if (numbers.size() != 3) return wrong_count(kind, 3, numbers.size());
    material->density = numbers[0];
    material->young = numbers[1];
    material->poisson = numbers[2];
  } else {
    const OrthotropicKind* found = nullptr;
    for (const OrthotropicKind& known : kOrthotropic)
      if (known.name == kind) found = &known;
    if (found == nullptr)
      return content_error("expected a material ENU or ORTHOTROPIC (St. Venant-Kirchhoff), found " +
                           quoted_text(kind));
    material = orthotropic(*found, numbers);
    if (!material) return material;
  }
  const Status status = check_material(*material);
  if (!status) return status.error();
  return material;
}

}  // namespace tremolo
