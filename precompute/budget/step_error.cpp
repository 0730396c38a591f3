// The error of the step: two runs of the program `tremolo`.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/wait.h>

#include "common/text.h"
#include "precompute/budget/error_budget.h"
#include "precompute/system/child_program.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr double kStep = 0.003;     // s, the default of `tremolo run`
constexpr int kParts = 15;          // of it in the run that counts as exact
constexpr double kDuration = 0.45;  // s

// A folder for the runs' tables, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (fs::temp_directory_path() / "tremolo-budget-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr)
      throw Failure(system_error("no folder can be made in " + fs::temp_directory_path().string()));
    path_ = pattern;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string in(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

// Rows of the coordinates in a run's table.
std::vector<std::vector<double>> coordinates_of(const std::string& table) {
  std::ifstream file(table);
  std::string line, cell;
  std::getline(file, line);
  std::vector<bool> is_coordinate;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');)
    is_coordinate.push_back(cell.size() > 1 && cell[0] == 'q' &&
                            cell.find_first_not_of("0123456789", 1) == std::string::npos);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::size_t column = 0; std::getline(cells, cell, ','); ++column)
      if (column < is_coordinate.size() && is_coordinate[column])
        rows.back().push_back(std::strtod(cell.c_str(), nullptr));
  }
  return rows;
}

}  // namespace

double step_error(const std::string& file) {
  std::string looked_at;
  const std::string program = program_beside("tremolo", looked_at);
  if (program.empty())
    throw Failure(
        system_error("the program tremolo, which moves the reduced model, is not beside "
                     "this one (" +
                     looked_at + ")"));
  const ScratchFolder scratch;
  const auto run = [&](const std::string& name, int parts) {
    const int status = run_child(
        program,
        {"tremolo", "run", file, "--load", "square", "--step", text("%.17g", kStep / parts),
         "--duration", text("%.17g", kDuration), "--every", std::to_string(parts), "--tolerance",
         parts > 1 ? "1e-9" : "1e-6", "--coordinate", "all", "--out", scratch.in(name)},
        std::nullopt, true);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
      throw Failure(system_error(
          text("tremolo run ended with status %d at a step of %g s", status, kStep / parts)));
    return coordinates_of(scratch.in(name) + "/run.csv");
  };
  const auto rough = run("rough", 1), fine = run("fine", kParts);
  if (rough.size() != fine.size() || rough.size() < 2)
    throw Failure(system_error("the two runs of tremolo have other rows than expected"));
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < rough.size(); ++i) {
    double off = 0, size = 0;
    for (std::size_t k = 0; k < fine[i].size() && k < rough[i].size(); ++k) {
      off += std::pow(rough[i][k] - fine[i][k], 2);
      size += std::pow(fine[i][k], 2);
    }
    worst = std::max(worst, off);
    largest = std::max(largest, size);
  }
  if (!(largest > 0)) throw Failure(system_error("the reduced model does not move under its load"));
  return std::sqrt(worst / largest);
}

}  // namespace tremolo
