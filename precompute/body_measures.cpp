#include "precompute/body_measures.h"

#include <algorithm>
#include <limits>

#include "common/text.h"
#include "precompute/problem/material_rules.h"
#include "precompute/soundness.h"

namespace tremolo {

double total_mass(const Problem& problem) {
  double mass = 0;
  const std::vector<MaterialShare> shares = material_shares(problem.materials, problem.mesh);
  for (std::size_t i = 0; i < shares.size(); ++i)
    mass += shares[i].volume * problem.materials.materials[i].material.density;
  for (const PointMass& points : problem.point_masses) mass += points.kilograms;
  return mass;
}

double body_size(const Problem& problem) {
  std::vector<Eigen::Vector3d> used;
  for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v)
    if (problem.report.part_of_vertex[v] >= 0) used.push_back(problem.mesh.vertices[v]);
  return bounding_box(used).diagonal();
}

double small_shift(const Problem& problem, const Solid& solid) {
  const double size = body_size(problem);
  double softest = std::numeric_limits<double>::max();
  for (const NamedMaterial& named : problem.materials.materials) {
    const Material& material = named.material;
    softest = std::min(softest, !material.orthotropic
                                    ? material.young
                                    : std::min(material.orthotropic->young.minCoeff(),
                                               2.0 * material.orthotropic->shear.minCoeff()));
  }
  double points = 0;
  for (const PointMass& mass : problem.point_masses) points += mass.kilograms;
  const double density = *std::max_element(solid.densities.begin(), solid.densities.end()) *
                         (1.0 + points / (total_mass(problem) - points));
  return -1e-3 * softest / (density * size * size);
}

std::vector<std::string> material_notes(const Problem& problem, const Solid& solid) {
  std::vector<std::string> notes;
  const MaterialTable& table = problem.materials;
  const std::vector<MaterialShare> shares = material_shares(table, problem.mesh);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const NamedMaterial& named = table.materials[i];
    if (shares.size() == 1 && !named.material.orthotropic) break;
    notes.push_back(
        named.name + ": " + std::to_string(shares[i].tetrahedra) + " tetrahedra, " +
        text("%.4g m^3, %.4g kg", shares[i].volume, shares[i].volume * named.material.density) +
        ", " + describe(named.material));
  }
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    notes.push_back(text(
        "the stiffest material is %.0e times as stiff as the softest: digits are lost", ratio));
  for (const PointMass& mass : problem.point_masses)
    notes.push_back(text("%.4g kg on %zu vertices: ", mass.kilograms, mass.vertices.size()) +
                    mass.selector);
  return notes;
}

}  // namespace tremolo
