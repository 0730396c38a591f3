// Energies of runs over time, as charts of a page.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace tremolo {

// The page in a run's folder.
inline constexpr const char* kEnergyPageName = "energy.html";

// `tremolo plot`: the energies of these folders of `tremolo run --out`. The exit code; errors are
// printed on stderr.
int plot_command(const std::vector<std::string>& directories, const std::string& output);

// One run: a label and its run.csv.
struct PlotSource {
  std::string label;
  std::string csv;
};

// Sources are folders of `tremolo run --out`, or CSV files; the label is the folder's name.
std::vector<PlotSource> plot_sources(const std::vector<std::string>& runs);

// A run's columns: t (s), total and, where there is one, high_band (J); an empty cell is a NaN.
struct EnergyTable {
  std::vector<double> t;
  std::vector<double> total;
  std::vector<double> high_band;
};
// Errors: kSystem; kContent, with the line, for a table without t and total or a cell that is no
// number.
Result<EnergyTable> read_energies(const std::string& csv);

// The value of a page's `charts` (runtime/io/page/document.h): total energy and, of runs that have
// one, that of the high band; the two zoom together. of_film: a film on the page has the same time.
Result<nlohmann::ordered_json> energy_charts(const std::vector<PlotSource>& sources, bool of_film);

// A page of the two. Errors: as read_energies; kSystem.
Status write_energy_page(const std::vector<PlotSource>& sources, const std::string& output);

// Writes the page to a folder and adds its path to `files`. Errors as write_energy_page.
Status plot_run(const PlotSource& source, const std::string& folder,
                std::vector<std::string>& files);

}  // namespace tremolo
