#include "runtime/apps/view/shape/surface_stress.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_layout.h"
#include "formats/basis/basis_reader.h"

namespace tremolo {
namespace {

using Eigen::Matrix2f;
using Eigen::Vector3d;

constexpr double kFlat = 1e-12;      // twice an area over a side squared: no area
constexpr float kThinnest = 0.01f;   // of the thickness' square
constexpr std::size_t kDeepest = 8;  // tremolo-precompute writes 4

// The triangle in its own plane: columns X1 - X0 and X2 - X0; a zero matrix where it is flat.
Eigen::Matrix2d plane_edges(const Vector3d& a, const Vector3d& b) {
  Eigen::Matrix2d edges = Eigen::Matrix2d::Zero();
  const double length = a.norm(), twice = a.cross(b).norm();
  if (!(twice > kFlat * std::max(a.squaredNorm(), b.squaredNorm()))) return edges;
  edges << length, a.dot(b) / length, 0.0, twice / length;
  return edges;
}

}  // namespace

SurfaceStress::SurfaceStress(const std::vector<Vector3d>& rest, std::span<const Triangle> triangles,
                             const Material& material)
    : vertices_(rest.size()), area_(rest.size(), 0.0f) {
  for (const Triangle& t : triangles) add(rest, t, material);
}

SurfaceStress::SurfaceStress(const std::vector<Vector3d>& rest, std::span<const Triangle> triangles,
                             std::span<const std::optional<Material>> materials)
    : vertices_(rest.size()), area_(rest.size(), 0.0f) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (materials[t]) add(rest, triangles[t], *materials[t]);
}

void SurfaceStress::add(const std::vector<Vector3d>& rest, const Triangle& t,
                        const Material& material) {
  const Vector3d a = rest[t[1]] - rest[t[0]], b = rest[t[2]] - rest[t[0]];
  const Eigen::Matrix2d edges = plane_edges(a, b);
  if (edges.isZero(0.0)) return;
  const double twice = edges.determinant();
  const double longest = std::max({a.norm(), b.norm(), (b - a).norm()});
  StressPatch patch;
  patch.corners = t;
  patch.inverse = edges.inverse().cast<float>();
  patch.area = static_cast<float>(0.5 * twice);
  patch.height = static_cast<float>(twice / longest);
  patch.young = static_cast<float>(material.young);
  patch.poisson = static_cast<float>(material.poisson);
  for (const VertexId v : t) area_[v] += patch.area;
  patches_.push_back(patch);
}

float SurfaceStress::of_patch(const StressPatch& patch, std::span<const float> positions) const {
  const auto place = [&](int corner) {
    return Eigen::Map<const Eigen::Vector3f>(positions.data() +
                                             3 * static_cast<std::size_t>(patch.corners[corner]));
  };
  Eigen::Matrix<float, 3, 2> moved;
  moved << place(1) - place(0), place(2) - place(0);
  const Eigen::Matrix<float, 3, 2> f = moved * patch.inverse;
  const Matrix2f c = f.transpose() * f;
  const Matrix2f strain = 0.5f * (c - Matrix2f::Identity());
  const float nu = patch.poisson, trace = strain.trace();
  const Matrix2f s =
      patch.young / (1.0f - nu * nu) * ((1.0f - nu) * strain + nu * trace * Matrix2f::Identity());
  const float thickness = std::max(1.0f - 2.0f * nu / (1.0f - nu) * trace, kThinnest);
  const float j = std::sqrt(std::max(c.determinant() * thickness, 1e-12f));
  // Traces of sigma and of its square, without sigma itself.
  const Matrix2f mixed = s * c;
  const float first = mixed.trace() / j, second = (mixed * mixed).trace() / (j * j);
  return std::sqrt(std::max(1.5f * (second - first * first / 3.0f), 0.0f));
}

float SurfaceStress::look(std::span<const float> positions, std::vector<float>& out) const {
  out.assign(vertices_, 0.0f);
  float reach = 0.0f;  // the largest coordinate, m
  for (const float x : positions) reach = std::max(reach, std::abs(x));
  bool loaded = false;
  for (const StressPatch& patch : patches_) {
    const float stress = of_patch(patch, positions);
    loaded = loaded || stress > patch.young * (kLeastStress + kRounding * reach / patch.height);
    for (const VertexId v : patch.corners) out[v] += patch.area * stress;
  }
  if (!loaded) {
    out.assign(vertices_, 0.0f);
    return 0.0f;
  }
  float most = 0.0f;
  for (std::size_t v = 0; v < vertices_; ++v) {
    if (area_[v] > 0.0f) out[v] /= area_[v];
    most = std::max(most, out[v]);
  }
  return most;
}

std::optional<Material> material_of_provenance(std::string_view provenance) {
  bool deep = false;
  const nlohmann::json json = nlohmann::json::parse(
      provenance,
      [&deep](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
        deep = deep || std::cmp_greater(depth, kDeepest);
        return !deep;
      },
      false);
  if (deep || !json.is_object() || !json.contains("material")) return std::nullopt;
  const nlohmann::json& entry = json["material"];
  const auto number = [&entry](const char* key) {
    return entry.is_object() && entry.contains(key) && entry[key].is_number()
               ? entry[key].get<double>()
               : -1.0;
  };
  Material material;
  material.young = number("young_pa");
  material.poisson = number("poisson");
  const bool good = material.young > 0.0 && std::isfinite(material.young) &&
                    material.poisson >= 0.0 && material.poisson < 0.5;
  return good ? std::optional(material) : std::nullopt;
}

std::optional<Material> material_of_model(const std::string& path) {
  Result<BasisReader> reader = BasisReader::open(path);
  if (!reader || !reader->has(basis_layout::kProvenance)) return std::nullopt;
  const Result<std::string_view> text = reader->text(basis_layout::kProvenance);
  return text ? material_of_provenance(*text) : std::nullopt;
}

}  // namespace tremolo
