// An Abaqus input file as it is written: parts with nodes, elements and sets, and their instances.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/result.h"
#include "formats/file/scanner.h"
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
  std::size_t bytes = 0;                         // of all files
};

// Reads a whole file and those that it includes. Errors: kContent with the line; what would be
// generated (*NGEN, *ELCOPY) or lies in other coordinate systems is refused by its keyword; kSystem
// for an included file that cannot be read.
Result<InpModel> parse_inp(std::string_view text, const std::string& path);

// The lines of an Abaqus input file with those of the files it includes: keywords with parameters,
// and the data behind them.

// A line such as `*Element, type=C3D4, elset="Part one"`.
struct InpKeyword {
  std::string name;  // upper case, without the star: "ELEMENT", "SOLID SECTION"
  std::map<std::string, std::string> parameters;  // name in upper case -> value as written

  bool has(const std::string& parameter) const { return parameters.contains(parameter); }
  // Empty if it is not given.
  std::string value(const std::string& parameter) const;
};

// Goes over keywords and data lines; comments (two stars) and empty lines are passed over. The
// lines of a file that *INCLUDE names stand where it stands, be they keywords or data. Such a file
// lies in the folder of the one that names it or below; none includes itself, and all together are
// at most kMostRepeats times as large as they are on disk.
class InpInput {
 public:
  InpInput(std::string_view text, const std::string& path);

  // Goes to the next keyword; false at the end of the file or after an error (failed()).
  bool next_keyword(InpKeyword& keyword);
  // Goes to the next data line of this keyword; false if there is none.
  bool next_data();
  // True if the current data line ends in a comma: its record continues on the next line.
  bool continues() const;
  // The lines of this file are next: what *NODE and *ELEMENT say with INPUT. False after an error.
  bool include(const std::string& name);

  TextScanner& line() { return sources_.back().scanner; }
  bool failed() const { return !error_.message.empty(); }
  const Error& error() const { return failed() ? error_ : sources_.back().scanner.error(); }
  Error problem(const std::string& text) const { return sources_.back().scanner.problem(text); }
  // Bytes that have been opened so far, those of a file once for each time.
  std::size_t bytes() const { return bytes_; }

 private:
  enum class Line { kKeyword, kData, kEnd };
  // place: the path without links and detours, empty for the first file if it is not on disk.
  struct Source {
    TextScanner scanner;
    std::string path;
    std::string place;
    bool started = false;
  };
  // Goes to the start of the next line that is neither empty nor a comment nor *INCLUDE.
  Line advance();
  std::string_view rest() const;
  bool fail(const std::string& text);

  std::vector<Source> sources_;               // the file being read is the last
  std::map<std::string, std::string> texts_;  // of the included files, by place
  std::size_t bytes_ = 0;
  std::size_t distinct_bytes_ = 0;
  Error error_;
  bool at_keyword_ = false;  // a keyword was met while data were looked for
};

}  // namespace tremolo
