// A stated bound and the measured value.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremolo {

// decides: false for figures that are shown without a bound of their own; they never fail a run.
// elsewhere: another command measures it, `measured` says which; it decides nothing here either.
struct Criterion {
  std::string what;      // "ep4, energy drift over 3.33 million steps"
  std::string bound;     // "<= 1e-9"
  std::string measured;  // "4e-13"
  bool met = false;
  bool decides = true;
  bool elsewhere = false;
};

// Met if measured is at most `bound`; never for not-a-number. who: the run with that value, shown
// behind it. bound_text: how the bound is written ("1/5"), empty for three digits.
Criterion at_most(std::string what, double measured, double bound, const std::string& who = {},
                  const std::string& bound_text = {});

// "met", "MISSED", "shown" or "elsewhere".
std::string_view verdict(const Criterion& criterion);

// "18 of 19 criteria are met; missed: ... . 5 are shown without a bound, ..."
std::string verdict(const std::vector<Criterion>& criteria);

// 0 if every deciding criterion is met, 6 otherwise.
int exit_code(const std::vector<Criterion>& criteria);

// An array of objects with what, bound, measured, met, decides.
nlohmann::ordered_json to_json(const std::vector<Criterion>& criteria);

// A line each on stderr.
void print(const std::vector<Criterion>& criteria);

}  // namespace tremolo
