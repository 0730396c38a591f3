// Text decks: Abaqus, Nastran, TetGen and VegaFEM, in the forms of Gmsh and meshio.
#pragma once

#include "tests/support/meshes/forms/form_mesh.h"
#include "tests/support/meshes/vega_files.h"

namespace tremolo::testing {

inline std::string inp_nodes(const TetMesh& mesh, const Eigen::Vector3d& shift,
                             const std::string& keyword) {
  std::string text = keyword + "\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d x = mesh.vertices[v] + shift;
    text += std::to_string(v + 1) + ", " + number(x[0]) + ", " + number(x[1]) + ", " +
            number(x[2]) + "\n";
  }
  return text;
}

inline std::string inp_elements(const FormBar& bar, int half, const std::string& keyword) {
  std::string text = keyword + "\n";
  for (const std::size_t t : bar.tets_of_half(half))
    text += std::to_string(t + 1) + ", " + joined(bar.mesh.tetrahedra[t], ", ", 1) + "\n";
  return text;
}

// Ten ids on a line, each followed by a comma, as Gmsh writes sets.
inline std::string inp_list(const std::vector<std::size_t>& ids) {
  std::string text;
  for (std::size_t n = 0; n < ids.size(); ++n)
    text += std::to_string(ids[n] + 1) + ", " + (n % 10 == 9 ? "\n" : "");
  return text + "\n";
}

inline std::string inp_of_gmsh() {
  const FormBar bar;
  std::string text = "*Heading\n a.inp\n" + inp_nodes(bar.mesh, {0, 0, 0}, "*NODE") +
                     "******* E L E M E N T S *************\n*ELEMENT, type=CPS3, ELSET=Surface5\n";
  std::vector<std::size_t> ids;
  for (std::size_t n = 0; n < bar.foot_triangles.size(); ++n) {
    ids.push_back(1000 + n);
    text += std::to_string(1001 + n) + ", " + joined(bar.foot_triangles[n], ", ", 1) + "\n";
  }
  text += inp_elements(bar, 0, "*ELEMENT, type=C3D4, ELSET=Volume1") +
          inp_elements(bar, 1, "*ELEMENT, type=C3D4, ELSET=Volume2");
  return text + "*ELSET,ELSET=foot\n" + inp_list(ids) + "*ELSET,ELSET=low\n" +
         inp_list(bar.tets_of_half(0)) + "*ELSET,ELSET=high\n" + inp_list(bar.tets_of_half(1));
}

inline std::string inp_of_meshio() {
  const FormBar bar;
  return "*HEADING\nAbaqus DataFile Version 6.14\nwritten by meshio v5.0.0\n" +
         inp_nodes(bar.mesh, {0, 0, 0}, "*NODE") + inp_elements(bar, 0, "*ELEMENT, TYPE=C3D4") +
         inp_elements(bar, 1, "*ELEMENT, TYPE=C3D4") + "*ELSET, ELSET=low\n" +
         inp_list(bar.tets_of_half(0)) + "*ELSET, ELSET=high\n" + inp_list(bar.tets_of_half(1)) +
         "*NSET, NSET=foot\n" + joined(bar.foot, ",", 1) + "\n";
}

// The nodes in a file of their own.
inline std::vector<std::pair<std::string, std::string>> inp_in_files() {
  const std::string text = inp_of_meshio();
  const std::size_t nodes = text.find("*NODE\n") + 6, elements = text.find("*ELEMENT");
  return {{"a.inp", text.substr(0, nodes) + "*INCLUDE, INPUT=nodes.txt\n" + text.substr(elements)},
          {"nodes.txt", text.substr(nodes, elements - nodes)}};
}

// As Abaqus/CAE writes: a part in its own place, an instance, sections, sets of the assembly, and a
// step behind it all.
inline std::string inp_of_cae() {
  const FormBar bar;
  const std::size_t low = bar.tets_of_half(0).size();
  // Ids so that the first half's are consecutive.
  std::string elements = "*Element, type=C3D4\n";
  std::size_t id = 0;
  for (const int half : {0, 1})
    for (const std::size_t t : bar.tets_of_half(half))
      elements += std::to_string(++id) + ", " + joined(bar.mesh.tetrahedra[t], ", ", 1) + "\n";
  return "*Heading\n** Job name: Job-1 Model name: Model-1\n*Preprint, echo=NO, model=NO\n**\n"
         "** PARTS\n**\n*Part, name=Part-1\n" +
         inp_nodes(bar.mesh, {-2, 8, 0.5}, "*Node") + elements +
         "*Elset, elset=LOW, generate\n1, " + std::to_string(low) + ", 1\n" +
         "*Elset, elset=\"HIGH\", generate\n " + std::to_string(low + 1) + ", " +
         std::to_string(id) +
         ", 1\n** Section: one\n*Solid Section, elset=low, material=Rubber\n,\n"
         "*Solid Section, elset=High,\n material=Rubber\n,\n*End Part\n**\n*Assembly, "
         "name=Assembly\n"
         "**\n*Instance, name=Part-1-1, part=PART-1\n2., -8., -0.5\n*End Instance\n**\n"
         "*Nset, nset=foot, instance=Part-1-1\n " +
         joined(bar.foot, ", ", 1) +
         "\n*End Assembly\n**\n** MATERIALS\n**\n*Material, "
         "name=Rubber\n*Density\n1000.,\n*Elastic\n"
         " 1e+06, 0.3\n** STEP: one\n*Step, name=one, nlgeom=NO\n*Static\n1., 1.\n*End Step\n";
}

// Ten nodes: Abaqus breaks the line after the ninth; other writers break it anywhere.
inline std::string inp_quadratic() {
  const QuadraticBar bar;
  std::string text = "*HEADING\nten nodes\n" + inp_nodes(bar.mesh, {0, 0, 0}, "*NODE, NSET=ALL") +
                     "*ELEMENT, TYPE=C3D10M, ELSET=solid\n";
  for (std::size_t t = 0; t < bar.cells.size(); ++t) {
    const auto& cell = bar.cells[t];
    const std::vector<VertexId> first(cell.begin(), cell.begin() + 7),
        rest(cell.begin() + 7, cell.end());
    text += std::to_string(t + 1) + ", " + joined(first, ", ", 1) + ",\n " + joined(rest, ", ", 1) +
            "\n";
  }
  return text + "*NSET, NSET=foot\n" + joined(FormBar().foot, ", ", 1) + "\n";
}

// A card in fields of 8 or 16 columns; text: the values, name first.
inline std::string fixed_card(const std::vector<std::string>& fields, std::size_t width) {
  const std::size_t on_line = width == 8 ? 8 : 4;
  const auto padded = [](std::string field, std::size_t columns) {
    field.resize(std::max(columns, field.size()), ' ');
    return field;
  };
  std::string text = padded(fields[0] + (width == 8 ? "" : "*"), 8);
  for (std::size_t n = 1; n < fields.size(); ++n) {
    if (n > 1 && (n - 1) % on_line == 0) text += width == 8 ? "\n        " : "\n*       ";
    text += padded(fields[n], width);
  }
  return text + "\n";
}

// 0.25 as "2.5-1", 1 as "1.": Nastran's own way.
inline std::string short_real(double value) {
  if (value == 0.25) return "2.5-1";
  if (value == 0.125) return "1.25-01";
  std::string text = number(value);
  if (text.find('.') == std::string::npos) text += ".";
  return text;
}

inline std::string free_card(const std::vector<std::string>& fields) {
  std::string text;
  for (std::size_t n = 0; n < fields.size(); ++n) {
    if (n > 1 && (n - 1) % 8 == 0) text += ",+\n+";
    text += (n == 0 ? "" : ",") + fields[n];
  }
  return text + "\n";
}

// width: of the fields, 0: free.
inline std::string form_bdf(std::size_t width, bool quadratic) {
  const FormBar bar;
  const QuadraticBar bent;
  const TetMesh& mesh = quadratic ? bent.mesh : bar.mesh;
  const auto card = [&](const std::vector<std::string>& fields) {
    return width == 0 ? free_card(fields) : fixed_card(fields, width);
  };
  std::string text =
      "SOL 101\nCEND\nSET 7 = " + joined(bar.foot, ",", 1) + "\nBEGIN BULK\n$ a comment\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& x = mesh.vertices[v];
    text += card(
        {"GRID", std::to_string(v + 1), "", short_real(x[0]), short_real(x[1]), short_real(x[2])});
  }
  for (std::size_t t = 0; t < bar.half.size(); ++t) {
    std::vector<std::string> fields = {"CTETRA", std::to_string(t + 1),
                                       std::to_string(1 + bar.half[t])};
    const auto add = [&](const auto& cell) {
      for (const VertexId v : cell) fields.push_back(std::to_string(v + 1));
    };
    if (quadratic)
      add(bent.cells[t]);
    else
      add(bar.mesh.tetrahedra[t]);
    text += card(fields);
  }
  text += card({"PSOLID", "1", "9"}) + card({"PSOLID", "2", "9"});
  return text + card({"MAT1", "9", "1.+6", "", "0.3", "1.+3"}) + "ENDDATA\n";
}

// The bulk data of Gmsh: eight columns, six decimals, triangles of the surface with a property.
inline std::string bdf_of_gmsh() {
  const FormBar bar;
  std::string text = "$ Created by Gmsh\n";
  const auto real = [](double value) {
    if (value == 0) return std::string("0.00E+00");
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.6f", value);
    return std::string(digits.data());
  };
  for (std::size_t v = 0; v < bar.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& x = bar.mesh.vertices[v];
    text += fixed_card({"GRID", std::to_string(v + 1), "0", real(x[0]), real(x[1]), real(x[2])}, 8);
  }
  std::size_t id = 0;
  for (const Triangle& t : bar.foot_triangles)
    text += fixed_card({"CTRIA3", std::to_string(++id), "3", std::to_string(t[0] + 1),
                        std::to_string(t[1] + 1), std::to_string(t[2] + 1)},
                       8);
  for (std::size_t t = 0; t < bar.half.size(); ++t) {
    const Tetrahedron& tet = bar.mesh.tetrahedra[t];
    text += fixed_card({"CTETRA", std::to_string(++id), std::to_string(1 + bar.half[t]),
                        std::to_string(tet[0] + 1), std::to_string(tet[1] + 1),
                        std::to_string(tet[2] + 1), std::to_string(tet[3] + 1)},
                       8);
  }
  return text + "ENDDATA\n";
}

// order: of the six further nodes, as two versions of TetGen have them; base: of the ids.
inline std::vector<std::pair<std::string, std::string>> tetgen_files(int base, bool quadratic,
                                                                     bool later) {
  const FormBar bar;
  const QuadraticBar bent;
  const TetMesh& mesh = quadratic ? bent.mesh : bar.mesh;
  std::string node = "# Node count, 3 dim, no attribute, boundary marker\n" +
                     std::to_string(mesh.vertices.size()) + "  3  0  1\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    node += std::to_string(v + base) + "  " + join(mesh.vertices[v]) +
            (mesh.vertices[v].x() == 0 && v < bar.mesh.vertices.size() ? "  5\n" : "  0\n");
  std::string ele = std::to_string(bar.half.size()) + (quadratic ? "  10  1\n" : "  4  1\n");
  for (std::size_t t = 0; t < bar.half.size(); ++t) {
    ele += std::to_string(t + base) + join(bar.mesh.tetrahedra[t], base);
    if (quadratic) {
      const auto& cell = bent.cells[t];
      for (const std::size_t n : later ? std::array<std::size_t, 6>{9, 7, 6, 8, 5, 4}
                                       : std::array<std::size_t, 6>{4, 5, 6, 7, 8, 9})
        ele += " " + std::to_string(cell[n] + base);
    }
    ele += " " + std::to_string(1 + bar.half[t]) + "\n";
  }
  return {{"a.node", node + "# Generated by tetgen\n"}, {"a.ele", ele + "# Generated by tetgen\n"}};
}

inline std::string form_veg(bool regions) {
  const FormBar bar;
  std::string text =
      "# Vega mesh file\n*VERTICES\n" + std::to_string(bar.mesh.vertices.size()) + " 3 0 0\n";
  for (std::size_t v = 0; v < bar.mesh.vertices.size(); ++v)
    text += std::to_string(v + 1) + " " + join(bar.mesh.vertices[v]) + "\n";
  text += "\n*ELEMENTS\nTET\n" + std::to_string(bar.half.size()) + " 4 0\n";
  for (std::size_t t = 0; t < bar.half.size(); ++t)
    text += std::to_string(t + 1) + join(bar.mesh.tetrahedra[t], 1) + "\n";
  if (!regions) return text;
  text += "\n*MATERIAL one\nENU, 1000, 1e6, 0.3\n*MATERIAL two\nENU, 1000, 1e6, 0.3\n";
  for (const int half : {0, 1}) {
    text += "*SET half" + std::to_string(half) + "\n";
    for (const std::size_t t : bar.tets_of_half(half)) text += std::to_string(t + 1) + ",\n";
  }
  return text + "*REGION\nhalf0, one\n*REGION\nhalf1, two\n";
}

inline std::vector<WriterForm> deck_forms() {
  const std::vector<std::string> properties = {"PID 1", "PID 2"}, named = {"low", "high"};
  return {
      {"gmsh", "Abaqus", {{"a.inp", inp_of_gmsh()}}, "foot", named},
      {"gmsh", "Nastran", {{"a.bdf", bdf_of_gmsh()}}, "PID 3", properties},
      {"meshio", "Abaqus", {{"a.inp", inp_of_meshio()}}, "foot", named},
      {"meshio", "Nastran, large field", {{"a.nas", form_bdf(16, false)}}, "SET 7", properties},
      {"Abaqus", "part and instance", {{"a.inp", inp_of_cae()}}, "foot", {"LOW", "HIGH"}},
      {"Abaqus", "INCLUDE", inp_in_files(), "foot", named},
      {"Abaqus", "C3D10", {{"a.inp", inp_quadratic()}}, "foot", {"solid"}, true},
      {"Nastran", "small field", {{"a.bdf", form_bdf(8, false)}}, "SET 7", properties},
      {"Nastran", "free field", {{"a.bdf", form_bdf(0, false)}}, "SET 7", properties},
      {"Nastran", "CTETRA of 10 nodes", {{"a.bdf", form_bdf(16, true)}}, "SET 7", properties, true},
      {"Nastran",
       "free field, 10 nodes",
       {{"a.bdf", form_bdf(0, true)}},
       "SET 7",
       properties,
       true},
      {"TetGen", "from 0", tetgen_files(0, false, false), "marker 5", {"region 1", "region 2"}},
      {"TetGen", "from 1", tetgen_files(1, false, false), "marker 5", {"region 1", "region 2"}},
      {"TetGen",
       "10 nodes",
       tetgen_files(1, true, false),
       "marker 5",
       {"region 1", "region 2"},
       true},
      {"TetGen",
       "10 nodes, other order",
       tetgen_files(0, true, true),
       "marker 5",
       {"region 1", "region 2"},
       true},
      {"VegaFEM", "text", {{"a.veg", form_veg(false)}}},
      {"VegaFEM", "text with regions", {{"a.veg", form_veg(true)}}, "", {"one", "two"}},
      {"VegaFEM", "binary", {{"a.vegb", vegb_bytes(FormBar().mesh)}}}};
}

}  // namespace tremolo::testing
