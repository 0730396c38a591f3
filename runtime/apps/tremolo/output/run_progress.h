// Progress of a long run, printed on stderr.
#pragma once

#include <chrono>
#include <string>

namespace tremolo {

// The lines about the progress. terminal: every half second, each line replaces the previous one;
// else a line after ten seconds and then every thirty. Short runs print nothing.
class RunProgress {
 public:
  // duration: of the run, s of simulated time.
  RunProgress(std::string name, double duration, bool terminal);

  // seconds: since the start of the work; reached: s of simulated time. Empty: nothing is due.
  std::string due(double seconds, double reached);
  // The text that erases the line on a terminal; empty if no line is shown.
  std::string end();

 private:
  std::string name_;
  double duration_;
  bool terminal_;
  double next_;
  std::size_t shown_ = 0;  // characters on the terminal's line
};

// The same on stderr by the clock.
class ToldProgress {
 public:
  ToldProgress(std::string name, double duration);
  ~ToldProgress();
  void reached(double time);

 private:
  RunProgress progress_;
  std::chrono::steady_clock::time_point start_;
};

// A signal during a run ends the run early; the results up to then are still written. While an
// object exists, the first SIGINT, SIGTERM or SIGHUP is stored and has no other effect. A second
// one is handled as before (formats/file/atomic_file.h): the program ends at once. There may be one
// object at a time, in programs only.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // The number of the signal that was received; 0: none.
  int signal() const;
};

}  // namespace tremolo
