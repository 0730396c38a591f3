#include "precompute/ranks/rank_agreement.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <new>
#include <sstream>
#include <thread>

#include "common/hash.h"
#include "formats/file/input_file.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// Returns `text` of rank `root` on all ranks.
std::string broadcast(std::string text, int root) {
  auto size = static_cast<unsigned long long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, root, PETSC_COMM_WORLD);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, root, PETSC_COMM_WORLD);
  return text;
}

// Separator of names and values, which never contain it.
constexpr char kEnd = '\0';

std::string pack(const std::vector<Fact>& facts) {
  std::string text;
  for (const Fact& fact : facts) text += fact.name + kEnd + fact.value + kEnd;
  return text;
}

std::vector<Fact> unpack(const std::string& text) {
  std::vector<Fact> facts;
  std::istringstream stream(text);
  for (Fact fact; std::getline(stream, fact.name, kEnd) && std::getline(stream, fact.value, kEnd);)
    facts.push_back(fact);
  return facts;
}

std::optional<Error> difference(const std::vector<Fact>& own, const std::vector<Fact>& first) {
  const auto disagree = [](const std::string& name, const std::string& a, const std::string& b) {
    return content_error("the ranks do not agree on " + name + ": here " +
                         (a.empty() ? "none" : a) + ", on rank 0 " + (b.empty() ? "none" : b) +
                         "; start all ranks with the same program, options and files");
  };
  for (std::size_t i = 0; i < std::max(own.size(), first.size()); ++i) {
    const Fact a = i < own.size() ? own[i] : Fact{}, b = i < first.size() ? first[i] : Fact{};
    if (a.name != b.name) return disagree("what there is to compare", a.name, b.name);
    if (a.value != b.value) return disagree(a.name, a.value, b.value);
  }
  return std::nullopt;
}

// A hash over several arrays.
class Digest {
 public:
  template <class T>
  Digest& add(const std::vector<T>& values) {
    parts_.push_back(hash_bytes(std::as_bytes(std::span(values))));
    return *this;
  }
  std::string text() const { return hash_text(hash_bytes(std::as_bytes(std::span(parts_)))); }

 private:
  std::vector<std::uint64_t> parts_;
};

std::string digest(const MaterialTable& table) {
  std::vector<double> numbers;
  const auto add = [&numbers](const auto& matrix) {
    numbers.insert(numbers.end(), matrix.data(), matrix.data() + matrix.size());
  };
  for (const NamedMaterial& named : table.materials) {
    const Material& material = named.material;
    add(Eigen::Vector3d(material.young, material.poisson, material.density));
    if (!material.orthotropic) continue;
    add(material.orthotropic->young);
    add(material.orthotropic->poisson);
    add(material.orthotropic->shear);
    add(material.orthotropic->axes);
  }
  return std::to_string(table.materials.size()) + ", " +
         Digest().add(numbers).add(table.of_tet).text();
}

// Settings that may differ between ranks: paths, thread counts of a host, and work of rank 0 only.
bool may_differ(const std::string& key) {
  constexpr std::array kKeys{"mesh",   "output",       "modes-vtu",   "preview",
                             "render", "threads",      "json",        "limits",
                             "config", "import-basis", "import-cubic"};
  return std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end();
}

}  // namespace

void fail_together(const std::optional<Error>& own) {
  const int ranks = mpi_ranks();
  const int first = over_ranks(own ? mpi_rank() : ranks, MPI_MIN);
  if (first == ranks) return;
  const int failed = over_ranks(own ? 1 : 0, MPI_SUM);
  int kind = own ? static_cast<int>(own->kind) : 0;
  MPI_Bcast(&kind, 1, MPI_INT, first, PETSC_COMM_WORLD);
  const std::string message = broadcast(own ? own->message : "", first);
  const std::string where = failed == ranks ? "" : "rank " + std::to_string(first) + ": ";
  throw SharedFailure({static_cast<ErrorKind>(kind), where + message});
}

std::string first_text(const std::string& own) {
  const int ranks = mpi_ranks();
  const int first = over_ranks(own.empty() ? ranks : mpi_rank(), MPI_MIN);
  if (first == ranks) return "";
  return (ranks == 1 ? "" : "rank " + std::to_string(first) + ": ") + broadcast(own, first);
}

Error current_error() {
  try {
    throw;
  } catch (const Failure& failure) {
    return failure.error();
  } catch (const std::bad_alloc&) {
    return system_error("out of memory");
  } catch (const std::exception& exception) {
    return system_error(exception.what());
  }
}

bool all_ranks_failed() {
  MPI_Request arrival = MPI_REQUEST_NULL;
  MPI_Ibarrier(PETSC_COMM_WORLD, &arrival);
  int all = 0;
  for (int round = 0; round < 200 && all == 0; ++round) {
    MPI_Test(&arrival, &all, MPI_STATUS_IGNORE);
    if (all == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return all != 0;
}

void require_agreement(const std::vector<Fact>& facts) {
  if (mpi_ranks() == 1) return;
  fail_together(difference(facts, unpack(broadcast(pack(facts), 0))));
}

std::string program_version() {
  return std::string(TREMOLO_VERSION) + " (" + unwrap(program_checksum()) + ")";
}

std::vector<Fact> facts_of_start(const std::string& settings,
                                 const std::vector<std::string>& petsc_options) {
  std::vector<Fact> facts{
      {"the program's version",
       program_version() + ", PETSc " + petsc_version() + ", SLEPc " + slepc_version()}};
  std::istringstream lines(settings);
  for (std::string line; std::getline(lines, line);) {
    const std::string key = line.substr(0, line.find('='));
    if (key.size() == line.size() || may_differ(key)) continue;
    facts.push_back({"--" + key, line.substr(key.size() + 1)});
  }
  std::string words;
  for (const std::string& word : petsc_options) words += (words.empty() ? "" : " ") + word;
  facts.push_back({"PETSc's options", words});
  return facts;
}

std::vector<Fact> facts_of(const Problem& problem) {
  Digest masses;
  for (const PointMass& mass : problem.point_masses)
    masses.add(std::vector<double>{mass.kilograms}).add(mass.vertices);
  return {{"the mesh", std::to_string(problem.mesh.vertices.size()) + " vertices, " +
                           std::to_string(problem.mesh.tetrahedra.size()) + " tetrahedra, " +
                           problem.mesh_hash},
          {"the elements' order", std::to_string(problem.order)},
          {"the fixed vertices",
           std::to_string(problem.fixed.size()) + ", " + Digest().add(problem.fixed).text()},
          {"the materials", digest(problem.materials)},
          {"the point masses", std::to_string(problem.point_masses.size()) + ", " + masses.text()}};
}

Fact render_fact(const Problem& problem) {
  if (!problem.render) return {"the render surface", ""};
  return {"the render surface",
          std::to_string(problem.render->vertices.size()) + " vertices, " +
              Digest().add(problem.render->vertices).add(problem.embedding.tetrahedra).text()};
}

Problem load_problem_together(const ProblemRequest& request) {
  Problem problem = on_all_ranks([&] { return load_problem(request); });
  std::vector<Fact> facts = facts_of(problem);
  facts.push_back(render_fact(problem));
  require_agreement(facts);
  const std::size_t ranks = mpi_ranks();
  if (ranks > problem.mesh.tetrahedra.size())
    throw SharedFailure(content_error(std::to_string(ranks) + " ranks for " +
                                      std::to_string(problem.mesh.tetrahedra.size()) +
                                      " tetrahedra: use fewer ranks"));
  return problem;
}

}  // namespace tremolo
