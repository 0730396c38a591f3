// Abaqus input files: parts at the positions of their instances.
#include <algorithm>
#include <optional>
#include <utility>

#include "common/text.h"
#include "formats/abaqus/inp_model.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_builder.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {
namespace {

// Ids of a part -> indices, ascending by id.
using IdTable = std::vector<std::pair<std::int64_t, std::size_t>>;

std::optional<std::size_t> index_of(const IdTable& table, std::int64_t id) {
  const auto found =
      std::lower_bound(table.begin(), table.end(), std::pair<std::int64_t, std::size_t>{id, 0});
  if (found == table.end() || found->first != id) return std::nullopt;
  return found->second;
}

template <class GetId>
IdTable make_table(std::size_t count, const GetId& id) {
  IdTable table;
  table.reserve(count);
  for (std::size_t n = 0; n < count; ++n) table.emplace_back(id(n), n);
  std::sort(table.begin(), table.end());
  return table;
}

// A part at one position in the mesh.
struct Placement {
  const InpPart* part = nullptr;
  std::string instance;  // empty: the file has none
  Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
  IdTable nodes;
  IdTable elements;
  std::int64_t first_vertex = 0;
  std::vector<std::size_t> first_tet;  // of each element, and one more
};

struct InpMesh {
  MeshBuilder builder;
  std::vector<Placement> placements;
  std::vector<std::string> region_names;
  std::vector<std::int64_t> region_of_tet;  // index into region_names, -1: none
  std::size_t missing = 0;                  // members of sets that the file does not have
};

Error in_part(const std::string& path, const Placement& placement, const std::string& text) {
  const std::string& name = placement.part->name;
  return content_error(path + (name.empty() ? "" : ", part " + quoted_text(name)) + ": " + text);
}

// The parts of the mesh: the instances, or all parts of a file without instances; and things
// outside of parts.
Result<std::vector<Placement>> find_placements(const InpModel& model, const std::string& path) {
  std::vector<Placement> placements;
  if (!model.flat.node_ids.empty() || !model.flat.elements.empty())
    placements.push_back({&model.flat, "", Eigen::Isometry3d::Identity(), {}, {}, 0, {}});
  for (const InpInstance& instance : model.instances) {
    const auto part = std::find_if(
        model.parts.begin(), model.parts.end(),
        [&](const InpPart& each) { return upper_case(each.name) == upper_case(instance.part); });
    if (part == model.parts.end())
      return content_error(path + ": instance " + quoted_text(instance.name) + " is of part " +
                           quoted_text(instance.part) + ", which the file does not have");
    placements.push_back({&*part, instance.name, instance.placed, {}, {}, 0, {}});
  }
  if (model.instances.empty())
    for (const InpPart& part : model.parts)
      placements.push_back({&part, part.name, Eigen::Isometry3d::Identity(), {}, {}, 0, {}});
  for (Placement& placement : placements) {
    const InpPart& part = *placement.part;
    placement.nodes =
        make_table(part.node_ids.size(), [&](std::size_t n) { return part.node_ids[n]; });
    placement.elements =
        make_table(part.elements.size(), [&](std::size_t n) { return part.elements[n].id; });
    for (const auto& [table, item] :
         {std::pair{&placement.nodes, "node"}, std::pair{&placement.elements, "element"}})
      for (std::size_t n = 1; n < table->size(); ++n)
        if ((*table)[n].first == (*table)[n - 1].first)
          return in_part(path, placement,
                         std::string(item) + " id " + std::to_string((*table)[n].first) +
                             " is given twice, expected every id once");
  }
  return placements;
}

// Instances repeat a part: together they may not be many times the file.
Status bound_size(const InpMesh& mesh, std::size_t bytes, const std::string& path) {
  std::size_t items = 0;
  for (const Placement& placement : mesh.placements)
    items += placement.nodes.size() + placement.elements.size();
  if (items <= 4 * bytes) return Success{};
  return content_error(path + ": its instances have " + std::to_string(items) +
                       " nodes and elements, expected at most " + std::to_string(4 * bytes) +
                       " in a file of this size");
}

Status add_nodes(const std::string& path, InpMesh& mesh) {
  for (Placement& placement : mesh.placements) {
    placement.first_vertex = static_cast<std::int64_t>(mesh.builder.vertex_count());
    for (const Eigen::Vector3d& x : placement.part->nodes)
      if (!mesh.builder.add_vertex(static_cast<std::int64_t>(mesh.builder.vertex_count()),
                                   placement.placed * x))
        return in_part(path, placement, mesh.builder.complaint());
  }
  if (!mesh.builder.seal_vertices()) return content_error(path + ": " + mesh.builder.complaint());
  return Success{};
}

// The mesh's numbers of an element's nodes. Nodes that do not exist get -1.
void nodes_of(const Placement& placement, const InpElement& element,
              std::vector<std::int64_t>& nodes) {
  nodes.clear();
  for (std::size_t n = 0; n < element.node_count; ++n) {
    const auto index =
        index_of(placement.nodes, placement.part->element_nodes[element.first_node + n]);
    nodes.push_back(index ? placement.first_vertex + static_cast<std::int64_t>(*index) : -1);
  }
}

// Elements other than solids may refer to reference points of the assembly: if their nodes are
// missing they are left out.
Status add_elements(const std::string& path, InpMesh& mesh) {
  std::vector<std::int64_t> nodes;
  std::vector<VertexId> vertices;
  for (Placement& placement : mesh.placements) {
    for (const InpElement& element : placement.part->elements) {
      placement.first_tet.push_back(mesh.builder.mesh().tetrahedra.size());
      nodes_of(placement, element, nodes);
      const auto absent = std::find(nodes.begin(), nodes.end(), -1);
      if (absent != nodes.end() && !element.kind->is_kept()) continue;
      if (absent != nodes.end())
        return in_part(
            path, placement,
            "element " + std::to_string(element.id) + " refers to node " +
                std::to_string(
                    placement.part->element_nodes[element.first_node + (absent - nodes.begin())]) +
                ", which the part does not have");
      if (!mesh.builder.resolve(element.id, nodes, vertices) ||
          !mesh.builder.add_cell(element.id, *element.kind, vertices))
        return in_part(path, placement, mesh.builder.complaint());
    }
    placement.first_tet.push_back(mesh.builder.mesh().tetrahedra.size());
  }
  return Success{};
}

void add_node_set(InpMesh& mesh, const Placement& placement, const InpSet& set,
                  const std::string& name) {
  std::vector<VertexId> vertices;
  for (const std::int64_t id : set.ids) {
    const auto index = index_of(placement.nodes, id);
    if (index)
      vertices.push_back(static_cast<VertexId>(placement.first_vertex + std::int64_t(*index)));
    else
      ++mesh.missing;
  }
  mesh.builder.add_to_set(name, vertices);
}

void add_element_set(InpMesh& mesh, const Placement& placement, const InpSet& set,
                     const std::string& name) {
  std::vector<VertexId> vertices;
  std::vector<std::int64_t> nodes;
  for (const std::int64_t id : set.ids) {
    const auto index = index_of(placement.elements, id);
    if (!index) {
      ++mesh.missing;
      continue;
    }
    nodes_of(placement, placement.part->elements[*index], nodes);
    for (const std::int64_t node : nodes)
      if (node >= 0) vertices.push_back(static_cast<VertexId>(node));
  }
  mesh.builder.add_to_set(name, vertices);
}

void put_in_region(InpMesh& mesh, const Placement& placement, const InpSet& set,
                   const std::string& region) {
  const auto label = static_cast<std::int64_t>(mesh.region_names.size());
  mesh.region_names.push_back(region);
  for (const std::int64_t id : set.ids)
    if (const auto index = index_of(placement.elements, id))
      for (std::size_t t = placement.first_tet[*index]; t < placement.first_tet[*index + 1]; ++t)
        mesh.region_of_tet[t] = label;
}

// A region is an element set that has a section; without sections each set is one, and the last
// that lists an element decides.
void add_regions(InpMesh& mesh, const Placement& placement) {
  const InpPart& part = *placement.part;
  if (!part.sections.empty()) {
    for (const InpSection& section : part.sections) {
      const auto found = part.element_sets.find(section.elset);
      if (found != part.element_sets.end())
        put_in_region(mesh, placement, found->second, found->second.name);
    }
    return;
  }
  std::vector<const InpSet*> sets;
  for (const auto& [key, set] : part.element_sets) sets.push_back(&set);
  std::sort(sets.begin(), sets.end(),
            [](const InpSet* a, const InpSet* b) { return a->order < b->order; });
  for (const InpSet* set : sets) put_in_region(mesh, placement, *set, set->name);
}

void add_materials(const InpModel& model, InpMesh& mesh) {
  for (const Placement& placement : mesh.placements)
    for (const InpSection& section : placement.part->sections) {
      const auto set = placement.part->element_sets.find(section.elset);
      const auto found = model.materials.find(section.material);
      if (set == placement.part->element_sets.end() || found == model.materials.end()) continue;
      const InpMaterial& material = found->second;
      std::string problem = material.problem;
      if (problem.empty() && !material.has_elastic) problem = "it has no *ELASTIC";
      if (problem.empty() && !material.has_density) problem = "it has no *DENSITY";
      mesh.builder.add_material({set->second.name, material.material, problem});
    }
}

void add_sets(const InpModel& model, InpMesh& mesh) {
  mesh.region_of_tet.assign(mesh.builder.mesh().tetrahedra.size(), -1);
  for (const Placement& placement : mesh.placements) {
    for (const auto& [key, set] : placement.part->node_sets)
      add_node_set(mesh, placement, set, set.name);
    for (const auto& [key, set] : placement.part->element_sets)
      add_element_set(mesh, placement, set, set.name);
    add_regions(mesh, placement);
    for (const InpAssemblySet& each : model.assembly_sets) {
      if (each.instance != upper_case(placement.instance)) continue;
      if (each.of_nodes)
        add_node_set(mesh, placement, each.set, each.set.name);
      else
        add_element_set(mesh, placement, each.set, each.set.name);
    }
  }
  add_materials(model, mesh);
  mesh.builder.set_regions(mesh.region_of_tet, [&](std::int64_t label) {
    return label < 0 ? std::string() : mesh.region_names[label];
  });
  if (mesh.missing > 0)
    mesh.builder.add_note(std::to_string(mesh.missing) +
                          " members of sets are no nodes or elements of their part: left out");
}

}  // namespace

Result<MeshFile> read_inp(std::string_view text, const std::string& path) {
  const Result<InpModel> model = parse_inp(text, path);
  if (!model) return model.error();
  Result<std::vector<Placement>> placements = find_placements(*model, path);
  if (!placements) return placements.error();
  InpMesh mesh{MeshBuilder(path), std::move(*placements), {}, {}};
  Status status = bound_size(mesh, model->bytes, path);
  if (status) status = add_nodes(path, mesh);
  if (status) status = add_elements(path, mesh);
  if (!status) return status.error();
  add_sets(*model, mesh);
  return mesh.builder.finish("Abaqus");
}

}  // namespace tremolo
