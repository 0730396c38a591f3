// Agreement between ranks: if ranks start with different input or one of them fails, all of them
// end with one message instead of waiting for each other for ever.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "precompute/problem/problem.h"
#include "precompute/system/failure.h"

namespace tremolo {

// A Failure that every rank throws: one rank reports it, and no abort is needed.
class SharedFailure : public Failure {
 public:
  using Failure::Failure;
};

// Throws on all ranks if any rank has an error: that of the lowest such rank, which the message
// names unless all ranks have one. own: this rank's error. Collective, as is all that follows it.
void fail_together(const std::optional<Error>& own);

// Returns the non-empty text of the lowest rank that has one, on all ranks; with several ranks it
// names that rank.
std::string first_text(const std::string& own);

// Returns the current exception as an error. Must be called in a catch block.
Error current_error();

// Returns the result of `work`; if it throws on some rank, all ranks throw.
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

// Returns whether all ranks call this within two seconds. Then all failed in the same way, as in a
// solver that does not converge, and one report suffices; otherwise the other ranks are still at
// work.
bool all_ranks_failed();

// A value to be compared, with a name that the user knows.
struct Fact {
  std::string name;
  std::string value;
};

// Throws SharedFailure (kContent) if a rank's facts differ from those of rank 0. The message names
// the first difference with both values.
void require_agreement(const std::vector<Fact>& facts);

// Returns the version with a checksum of the program file, since builds of the same version may
// compute differently.
std::string program_version();

// Returns the versions of the program and its libraries, PETSc's options, and the settings from
// command line and config file; paths, thread counts and settings of the output only are left out.
// settings: lines key=value.
std::vector<Fact> facts_of_start(const std::string& settings,
                                 const std::vector<std::string>& petsc_options);

// Returns mesh, materials, point masses and fixed vertices, by content.
std::vector<Fact> facts_of(const Problem& problem);

// The render surface is a separate fact, since it affects the file but no stage.
Fact render_fact(const Problem& problem);

// Calls load_problem on all ranks and compares the results. Throws SharedFailure (kContent) also if
// there are more ranks than tetrahedra.
Problem load_problem_together(const ProblemRequest& request);

}  // namespace tremolo
