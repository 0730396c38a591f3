#include "precompute/problem/point_mass.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/text.h"
#include "formats/basis/selector_reader.h"

namespace tremolo {

Result<PointMassRequest> parse_point_mass(const std::string& text) {
  // The selector may contain `=` as well, as in x>=1.2=0.5.
  const std::size_t equals = text.rfind('=');
  const std::string digits = equals == std::string::npos ? "" : text.substr(equals + 1);
  PointMassRequest mass{text, {}, 0};
  const auto [stop, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), mass.kilograms);
  if (equals == 0 || error != std::errc{} || stop != digits.data() + digits.size())
    return Error{ErrorKind::kUsage, "--point-mass " + text +
                                        ": expected SELECTOR=KG, a selector, `=` and a mass in kg"};
  if (!(mass.kilograms > 0) || !std::isfinite(mass.kilograms))
    return content_error("--point-mass " + text + ": the mass is " + number_text(mass.kilograms) +
                         ", must be positive and finite (kg)");
  if (Status parsed = take(mass.at, parse_selector(text.substr(0, equals))); !parsed)
    return parsed.error();
  return mass;
}

Result<PointMass> place_point_mass(const PointMassRequest& request, const TetMesh& mesh,
                                   const std::vector<VertexId>& fixed) {
  Result<std::vector<VertexId>> vertices = resolve_selector(request.at, mesh);
  if (!vertices) return vertices.error();
  if (vertices->empty())
    return content_error("--point-mass " + request.text + ": the mass must sit on a vertex");
  PointMass mass{request.at.text, request.kilograms, std::move(*vertices), 0};
  mass.fixed = static_cast<std::size_t>(
      std::count_if(mass.vertices.begin(), mass.vertices.end(),
                    [&](VertexId v) { return std::binary_search(fixed.begin(), fixed.end(), v); }));
  return mass;
}

std::vector<double> mass_of_vertices(const std::vector<PointMass>& masses, std::size_t vertices) {
  std::vector<double> kilograms(masses.empty() ? 0 : vertices, 0.0);
  for (const PointMass& mass : masses)
    for (VertexId v : mass.vertices)
      kilograms[v] += mass.kilograms / static_cast<double>(mass.vertices.size());
  return kilograms;
}

}  // namespace tremolo
