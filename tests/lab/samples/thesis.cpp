#include "tests/lab/samples/thesis.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/lab/samples/published.h"

namespace tremolo::thesis {
namespace {

int count(PublishedTable& table, std::string_view what) {
  const double value = table.number(what);
  if (value > 1e6 || value != std::floor(value)) table.fail(fmt::format("{} is no count", what));
  return static_cast<int>(value);
}

std::string model(PublishedTable& table) {
  std::string name = table.word("a model");
  if (std::ranges::find(kModels, name) == kModels.end()) table.fail("unknown model " + name);
  return name;
}

SignalKind load(PublishedTable& table) {
  const std::string name = table.word("a load");
  for (const SignalKind kind : kLoads)
    if (load_name(kind) == name) return kind;
  table.fail("unknown load " + name);
}

void read_modes(const std::string& directory, Thesis& thesis) {
  PublishedTable table(directory, "thesis-modes.csv", "model,r,low,high");
  while (table.next()) {
    Modes modes{model(table)};
    if (thesis.modes_of(modes.model)) table.fail(modes.model + " is there twice");
    modes.r = count(table, "r");
    modes.low = count(table, "a count of low modes");
    modes.high = count(table, "a count of high modes");
    if (modes.low + modes.high != modes.r) table.fail("low and high do not add up to r");
    thesis.modes.push_back(std::move(modes));
  }
  if (thesis.modes.size() != kModels.size()) table.fail("a model is missing by the end");
}

void read_runs(const std::string& directory, Thesis& thesis) {
  PublishedTable table(
      directory, "thesis-runs.csv",
      "table,alpha,load,model,imexv,newmark,imexv-iterations,newmark-iterations,speed-up,reached");
  while (table.next()) {
    Run run{.table = count(table, "a table's number"), .alpha = table.number("alpha")};
    run.load = load(table);
    run.model = model(table);
    run.imexv_seconds = table.number("seconds of IMEXv");
    run.newmark_seconds = table.number("seconds of Newmark");
    run.imexv_iterations = table.number("iterations of IMEXv");
    run.newmark_iterations = table.number("iterations of Newmark");
    run.speedup = table.number("a speed-up");
    run.reached = table.number("seconds reached");
    if (std::ranges::find(kAlphas, run.alpha) == kAlphas.end()) table.fail("unknown alpha");
    if (thesis.run(run.model, run.load, run.alpha)) table.fail("this run is there twice");
    thesis.runs.push_back(std::move(run));
  }
  if (thesis.runs.size() != kRuns) table.fail("a run is missing by the end");
}

void read_long_run(const std::string& directory, Thesis& thesis) {
  PublishedTable table(directory, "thesis-long-run.csv", "energy,change");
  const auto change = [&](const char* energy) {
    if (!table.next() || table.word(energy) != energy)
      table.fail(fmt::format("expected the change of '{}'", energy));
    return table.number("a change", -1.0);
  };
  thesis.total_change = change("total");
  thesis.high_band_change = change("high-band");
  if (table.next()) table.fail("expected the end of the file");
}

}  // namespace

std::string_view load_name(SignalKind load) {
  if (load == SignalKind::kImpulse) return "impulse";
  return load == SignalKind::kSquare ? "square" : "sine";
}

const Modes* Thesis::modes_of(std::string_view model) const {
  const auto found = std::ranges::find(modes, model, &Modes::model);
  return found == modes.end() ? nullptr : &*found;
}

const Run* Thesis::run(std::string_view model, SignalKind load, double alpha) const {
  for (const Run& entry : runs)
    if (entry.model == model && entry.load == load && std::abs(entry.alpha - alpha) < 1e-12)
      return &entry;
  return nullptr;
}

Thesis read_thesis(const std::string& directory) {
  Thesis thesis;
  read_modes(directory, thesis);
  read_runs(directory, thesis);
  read_long_run(directory, thesis);
  return thesis;
}

}  // namespace tremolo::thesis
