// `tremolo reproduce`: the thesis's tables, figures and experiments on the six sample models, its
// numbers next to ours, as one HTML page and CSVs.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/samples/published.h"

namespace tremolo {

// models: names, empty for all six. published: the folder of the thesis's numbers. threads: for the
// curves; timings use one. Below 1: all cores. only: "cloth" or "tets", reports of their own;
// empty: the thesis.
struct ReproduceOptions {
  std::vector<std::string> models;
  std::string models_directory = "build/models";
  std::string published = kPublishedDirectory;
  std::string out = "build/reproduce";
  bool long_form = false;
  int threads = 0;
  std::string only;
  bool json = false;
};

// Goes on where an earlier start was stopped. Returns 0, or 6 if a stated criterion is missed;
// throws a Failure.
int reproduce_command(const ReproduceOptions& options);

}  // namespace tremolo
