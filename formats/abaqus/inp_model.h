// An Abaqus input file as it is written: parts with nodes, elements and sets, and their instances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/result.h"
#include "formats/mesh/mesh_cells.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

struct InpElement {
  std::int64_t id = 0;
  const CellKind* kind = nullptr;
  std::size_t first_node = 0;  // of InpPart::element_nodes
  std::size_t node_count = 0;
};

// Names of Abaqus do not know upper and lower case: sets are found by upper_case(name).
struct InpSet {
  std::string name;               // as it is first written
  std::vector<std::int64_t> ids;  // of nodes or elements
  std::size_t order = 0;          // which of the file's sets was written to last
};
using InpSets = std::map<std::string, InpSet>;

struct InpSection {
  std::string elset;  // upper case
  std::string material;
};

// A part, or all that is outside of parts. Ids are the part's own.
struct InpPart {
  std::string name;
  std::vector<std::int64_t> node_ids;
  std::vector<Eigen::Vector3d> nodes;
  std::vector<InpElement> elements;
  std::vector<std::int64_t> element_nodes;
  InpSets node_sets;
  InpSets element_sets;
  std::vector<InpSection> sections;
};

struct InpInstance {
  std::string name;
  std::string part;
  Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
};

// A set of the assembly: ids of one instance.
struct InpAssemblySet {
  std::string instance;  // upper case
  bool of_nodes = true;
  InpSet set;
};

// problem: why the material cannot be used; empty: *ELASTIC and *DENSITY decide.
struct InpMaterial {
  std::string name;
  Material material;
  bool has_elastic = false;
  bool has_density = false;
  std::string problem;
};

struct InpModel {
  InpPart flat;
  std::vector<InpPart> parts;
  std::vector<InpInstance> instances;
  std::vector<InpAssemblySet> assembly_sets;
  std::map<std::string, InpMaterial> materials;  // by upper case of their names
};

// Reads a whole file. Errors: kContent with the line; generated parts (*NGEN, *ELCOPY), other files
// (*INCLUDE) and other coordinate systems are refused by their keyword.
Result<InpModel> parse_inp(std::string_view text, const std::string& path);

}  // namespace tremolo
