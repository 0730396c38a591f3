// Outputs appear whole or not at all, whatever interrupts the writing.
#include "formats/file/atomic_file.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::fresh_folder();
    std::ofstream(target()) << "old";
  }

  std::string target() const { return folder_ + "/file"; }
  std::string contents() const {
    std::ifstream stream(target());
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  long files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  // In a child process: begins to write, then gets `signal`. Returns the signal it died of.
  int interrupted_by(int signal) const {
    const pid_t child = ::fork();
    if (child == 0) {
      remove_partial_files_on_signals();
      const rlimit no_core{0, 0};
      ::setrlimit(RLIMIT_CORE, &no_core);
      Result<AtomicFile> file = AtomicFile::create(target());
      if (file && file->write(std::string(100000, 'n'))) ::raise(signal);
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  std::string folder_;
};

TEST_F(AtomicFileTest, TheTargetChangesOnlyOnCommit) {
  auto file = AtomicFile::create(target());
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE(file->write("new"));
  EXPECT_EQ(contents(), "old");
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(contents(), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, AnUncommittedFileLeavesNothing) {
  {
    auto file = AtomicFile::create(target());
    ASSERT_TRUE(file->write("new"));
  }
  EXPECT_EQ(contents(), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, ASignalInMidWriteRemovesThePartialFileAndStillKills) {
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXCPU, SIGUSR1, SIGUSR2, SIGALRM,
                     SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGABRT, SIGSYS, SIGRTMIN, SIGRTMAX}) {
    EXPECT_EQ(interrupted_by(signal), signal);
    EXPECT_EQ(contents(), "old");
    EXPECT_EQ(files(), 1);
  }
}

// Between two writes it takes no descriptor.
TEST_F(AtomicFileTest, AParkedFileGoesOnWhereItWas) {
  const auto descriptors = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const auto before = descriptors();
  auto file = AtomicFile::create(target());
  ASSERT_TRUE(file->write("one "));
  for (const char* word : {"two ", "three"}) {
    file->park();
    EXPECT_EQ(descriptors(), before);
    ASSERT_TRUE(file->write(word));
  }
  file->park();
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(contents(), "one two three");
  {
    auto left = AtomicFile::create(target());
    left->park();
  }
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, ASignalRemovesAsManyPartialFilesAsThereAre) {
  const pid_t child = ::fork();
  if (child == 0) {
    remove_partial_files_on_signals();
    std::vector<AtomicFile> open;
    for (int i = 0; i < 200; ++i) {
      auto file = AtomicFile::create(target() + std::to_string(i));
      if (!file) ::_exit(1);
      file->park();
      open.push_back(std::move(*file));
    }
    ::raise(SIGTERM);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, EvenSigkillLeavesTheTargetAsItWasAndTheNextWriterTidiesUp) {
  EXPECT_EQ(interrupted_by(SIGKILL), SIGKILL);
  EXPECT_EQ(contents(), "old");
  EXPECT_EQ(files(), 2);  // the target and the file of the dead process
  ASSERT_TRUE(write_file(target(), "new"));
  EXPECT_EQ(contents(), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, WhatAnotherProcessIsWritingAndWhatIsNotOursIsLeftAlone) {
  int ready[2], go_on[2];
  ASSERT_EQ(::pipe(ready), 0);
  ASSERT_EQ(::pipe(go_on), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    char byte = 0;
    auto file = AtomicFile::create(target());
    const bool began = file && file->write("theirs") && ::write(ready[1], "x", 1) == 1 &&
                       ::read(go_on[0], &byte, 1) == 1;
    ::_exit(began && file->commit() ? 0 : 1);
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  // Names that are only similar, of other targets or of no process.
  for (const char* name : {"/other.partial-12345", "/file.partial-12x", "/file.partial"})
    std::ofstream(folder_ + name) << "not a temporary file of ours";
  ASSERT_TRUE(write_file(target(), "ours"));
  EXPECT_EQ(contents(), "ours");
  EXPECT_EQ(files(), 5);
  ASSERT_EQ(::write(go_on[1], "x", 1), 1);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(contents(), "theirs");
}

TEST_F(AtomicFileTest, ThreadsMayWriteTheSameTarget) {
  std::vector<std::thread> threads;
  for (char c = 'a'; c < 'i'; ++c)
    threads.emplace_back([this, c] {
      for (int n = 0; n < 20; ++n) EXPECT_TRUE(write_file(target(), std::string(5000, c)));
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(contents(), std::string(5000, contents()[0]));
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, ASymbolicLinkKeepsPointingToTheNewContents) {
  fs::create_symlink("file", folder_ + "/link");
  ASSERT_TRUE(write_file(folder_ + "/link", "through"));
  EXPECT_TRUE(fs::is_symlink(folder_ + "/link"));
  EXPECT_EQ(contents(), "through");
}

TEST_F(AtomicFileTest, AFullDiskIsAnErrorAndTheTargetIsAsItWas) {
  // The limit on file size simulates a full disk: write() then fails in mid-file.
  const pid_t child = ::fork();
  if (child == 0) {
    remove_partial_files_on_signals();
    rlimit limit{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const Status status = write_file(target(), std::string(100000, 'n'));
    ::_exit(!status && status.error().kind == ErrorKind::kSystem ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(contents(), "old");
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace tremolo
