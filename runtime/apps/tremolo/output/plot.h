// Energies of runs over time: charts of a page, or a picture by gnuplot.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace tremolo {

// Files in a run's folder.
inline constexpr const char* kEnergyPageName = "energy.html";
inline constexpr const char* kPictureName = "energy.svg";

// Draws the total energy of the runs over time, one curve per run, and below it the energy of the
// high band for runs that have one (`tremolo-precompute reference` has none). The extension of
// `output` selects the format: .html, a page with zoom and values under the pointer; .svg or .png,
// by gnuplot. Errors: kUsage for another extension, kContent for a CSV without the columns t and
// total, kSystem if gnuplot is missing (the message says how to install it) or fails.
Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output);

// Writes energy.html to a folder and, if gnuplot is installed, energy.svg; adds the paths to
// `files`. Errors: as above, except for a missing gnuplot.
Status plot_run(const PlotSource& source, const std::string& folder,
                std::vector<std::string>& files);

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

// Within gnuplot's single quotes, where nothing but the quote itself is special. A line break,
// which would end the command, becomes a space.
std::string gnuplot_quoted(const std::string& text);

// True if gnuplot is on the PATH.
bool has_gnuplot();

// Runs a script that sets its own terminal and no output; returns the picture's bytes. Errors:
// kSystem if gnuplot is missing (the message says how to install it), fails or draws nothing.
// Messages of gnuplot go to stderr.
Result<std::string> run_gnuplot(const std::string& script);

}  // namespace tremolo
