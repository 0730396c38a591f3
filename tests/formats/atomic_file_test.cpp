// Outputs appear whole or not at all, whatever interrupts the writing.
#include "formats/atomic_file.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

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

  // In a child process: begins to write, then `signal` comes. Returns the signal it died of.
  int interrupted_by(int signal) const {
    const pid_t child = ::fork();
    if (child == 0) {
      remove_partial_files_on_signals();
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
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(interrupted_by(signal), signal);
    EXPECT_EQ(contents(), "old");
    EXPECT_EQ(files(), 1);
  }
}

TEST_F(AtomicFileTest, EvenSigkillLeavesTheTargetAsItWas) {
  EXPECT_EQ(interrupted_by(SIGKILL), SIGKILL);
  EXPECT_EQ(contents(), "old");
}

TEST_F(AtomicFileTest, ASymbolicLinkKeepsPointingToTheNewContents) {
  fs::create_symlink("file", folder_ + "/link");
  ASSERT_TRUE(write_file(folder_ + "/link", "through"));
  EXPECT_TRUE(fs::is_symlink(folder_ + "/link"));
  EXPECT_EQ(contents(), "through");
}

TEST_F(AtomicFileTest, AFullDiskIsAnErrorAndTheTargetIsAsItWas) {
  // The limit on file size stands in for a full disk: write() then fails in mid-file.
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
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
