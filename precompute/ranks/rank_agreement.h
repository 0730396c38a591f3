// Several ranks that start with different input, or of which one alone fails, must not wait for
// each other for ever: all of them end, with one message.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "precompute/problem/problem.h"
#include "precompute/system/failure.h"

namespace tremolo {

// A Failure that every rank throws: one rank tells it, nobody need be aborted.
class SharedFailure : public Failure {
 public:
  using Failure::Failure;
};

// When some rank has an error all ranks throw the lowest such rank's, which is named unless all
// have one. own: this rank's. To be called on all ranks together, as all that follows.
void fail_together(const std::optional<Error>& own);

// The lowest rank's text that is not empty, on all of them; of several ranks, that one is named.
std::string first_text(const std::string& own);

// What the work threw on this rank, as an error. To be called in a catch block.
Error current_error();

// The work's result; when it throws on some rank, all ranks throw.
template <class Work>
auto on_all_ranks(const Work& work) -> decltype(work()) {
  std::optional<decltype(work())> result;
  std::optional<Error> error;
  try {
    result = work();
  } catch (...) {
    error = current_error();
  }
  fail_together(error);
  return std::move(*result);
}

// Whether all ranks call this within two seconds. An error that every rank met alike, as a solver
// that gives up, need be told by one only; an error of one rank leaves the others in the midst of
// something.
bool all_ranks_failed();

// What is compared: a name that the user knows, and a value.
struct Fact {
  std::string name;
  std::string value;
};

// Throws SharedFailure (kContent) when a rank has other facts than rank 0: it names the first one
// that differs with both values.
void require_agreement(const std::vector<Fact>& facts);

// Of this program's very file: another build may number its versions alike and compute otherwise.
std::string program_version();

// Version of the program and its libraries, PETSc's options, and what the command line and its file
// say; paths, threads and what only shapes the output may differ. settings: lines key=value.
std::vector<Fact> facts_of_start(const std::string& settings,
                                 const std::vector<std::string>& petsc_options);

// Mesh, materials, masses, what is fixed: by content, wherever it was read from.
std::vector<Fact> facts_of(const Problem& problem);

// The surface that is drawn: it shapes the file, no stage.
Fact render_fact(const Problem& problem);

// load_problem on all ranks, which then agree. Throws SharedFailure (kContent) also when there are
// more ranks than tetrahedra.
Problem load_problem_together(const ProblemRequest& request);

}  // namespace tremolo
