// Failures in the child process stay in the child process.
#include "formats/file/limited_child.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using ChildBytes = std::vector<std::byte>;

ChildBytes bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

constexpr ChildLimits kLimits = {.seconds = 20, .memory = 0, .answer = 10'000'000};

std::string message_of(const ChildWork& work, const ChildLimits& limits = kLimits) {
  const Result<ChildBytes> answer = answer_of_child(work, limits);
  return answer ? "answered" : answer.error().message;
}

void expect_no_child_left() {
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(LimitedChild, AnswersCrossWhole) {
  ChildBytes sent(3'000'000);
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::byte>(i * i % 251);
  const Result<ChildBytes> answer = answer_of_child([&] { return sent; }, kLimits);
  ASSERT_TRUE(answer);
  EXPECT_EQ(*answer, sent);
  EXPECT_TRUE(answer_of_child([] { return ChildBytes(); }, kLimits)->empty());
  expect_no_child_left();
}

TEST(LimitedChild, ACrashIsAnError) {
  EXPECT_EQ(message_of([]() -> ChildBytes {
              ::raise(SIGSEGV);
              return {};
            }),
            "crashed (signal 11)");
  EXPECT_EQ(message_of([]() -> ChildBytes { std::abort(); }), "crashed (signal 6)");
  EXPECT_NE(message_of([]() -> ChildBytes { throw std::runtime_error("no"); }), "answered");
  EXPECT_NE(message_of([]() -> ChildBytes { ::_exit(5); }), "answered");
  expect_no_child_left();
}

TEST(LimitedChild, WhatNeverEndsIsEnded) {
  const auto for_ever = []() -> ChildBytes {
    for (;;) ::pause();
  };
  EXPECT_EQ(message_of(for_ever, {.seconds = 0.05, .answer = 10}), "took longer than 0.05 s");
  // One that talks all the time is not waited for either.
  const auto chatter = []() -> ChildBytes {
    for (;;)
      if (::write(3, "x", 1) != 1) ::_exit(0);
  };
  EXPECT_EQ(message_of(chatter, {.seconds = 0.05, .answer = UINT64_MAX}),
            "took longer than 0.05 s");
  expect_no_child_left();
}

TEST(LimitedChild, AnAnswerThatIsTooLongIsNotTaken) {
  EXPECT_NE(message_of([] { return ChildBytes(1001); }, {.seconds = 20, .answer = 1000}),
            "answered");
  EXPECT_EQ(message_of([] { return ChildBytes(1000); }, {.seconds = 20, .answer = 1000}),
            "answered");
  expect_no_child_left();
}

TEST(LimitedChild, MemoryIsWhatItMayBe) {
#if defined(TREMOLO_SANITIZED)
  GTEST_SKIP() << "the address space of a sanitized process is not limited";
#endif
  const auto take = [](std::size_t count) {
    return [count] {
      const ChildBytes taken(count, std::byte{1});
      return ChildBytes(1, taken[count / 2]);
    };
  };
  const ChildLimits limits = {.seconds = 20, .memory = 100'000'000, .answer = 1000};
  EXPECT_EQ(message_of(take(50'000'000), limits), "answered");
  EXPECT_EQ(message_of(take(150'000'000), limits), "needs more than 100 MB of memory");
}

TEST(LimitedChild, ItWritesNoFilesAndHasNoOtherDescriptors) {
  const int here = ::dup(2);
  const Result<ChildBytes> answer = answer_of_child(
      [] {
        std::string open;
        for (int descriptor = 0; descriptor < 64; ++descriptor)
          if (::fcntl(descriptor, F_GETFD) >= 0) open += std::to_string(descriptor) + " ";
        return bytes_of(open);
      },
      kLimits);
  ::close(here);
  ASSERT_TRUE(answer);
  EXPECT_EQ(*answer, bytes_of("0 1 2 3 "));
}

std::atomic<int> handled = 0;

TEST(LimitedChild, SignalsAreAsAtTheStartOfAProgram) {
  struct sigaction handler = {};
  struct sigaction before = {};
  handler.sa_handler = [](int) { ++handled; };
  ::sigaction(SIGTERM, &handler, &before);
  sigset_t term;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  sigset_t mask;
  pthread_sigmask(SIG_BLOCK, &term, &mask);
  EXPECT_EQ(message_of([]() -> ChildBytes {
              ::raise(SIGTERM);
              return {};
            }),
            "crashed (signal 15)");
  pthread_sigmask(SIG_SETMASK, &mask, nullptr);
  ::sigaction(SIGTERM, &before, nullptr);
  EXPECT_EQ(handled, 0);
}

TEST(LimitedChild, SignalsToTheParentDoNotCutTheAnswerShort) {
  struct sigaction handler = {};
  struct sigaction before = {};
  handler.sa_handler = [](int) { ++handled; };
  ::sigaction(SIGUSR1, &handler, &before);
  handled = 0;
  const pthread_t reader = pthread_self();
  std::atomic<bool> done = false;
  std::thread nuisance([&] {
    while (!done) {
      pthread_kill(reader, SIGUSR1);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  const Result<ChildBytes> answer = answer_of_child(
      [] {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return ChildBytes(2'000'000);
      },
      kLimits);
  done = true;
  nuisance.join();
  ::sigaction(SIGUSR1, &before, nullptr);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer->size(), 2'000'000U);
  EXPECT_GT(handled, 0);
}

TEST(LimitedChild, WhereChildrenAreNotWaitedForTheAnswerStillComes) {
  struct sigaction ignore = {};
  struct sigaction before = {};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGCHLD, &ignore, &before);
  const std::string message = message_of([] { return ChildBytes(10); });
  ::sigaction(SIGCHLD, &before, nullptr);
  EXPECT_EQ(message, "answered");
}

TEST(LimitedChild, ItDiesWithItsParent) {
  std::array<int, 2> ends = {};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const pid_t parent = ::fork();
  if (parent == 0) {
    (void)answer_of_child(
        [&]() -> ChildBytes {
          // Identifies itself through the answer's pipe's owner: descriptor 3 is all it has.
          for (;;) ::pause();
        },
        {.seconds = 60, .answer = 10});
    ::_exit(0);
  }
  ::close(ends[1]);
  // The grandchild holds no end of this pipe (it closes what it has): its end shows in /proc.
  std::string children;
  for (int attempt = 0; attempt < 2000 && children.empty(); ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::string task = "/proc/" + std::to_string(parent);
    std::FILE* file =
        std::fopen((task + "/task/" + std::to_string(parent) + "/children").c_str(), "r");
    if (file == nullptr) break;
    std::array<char, 32> text = {};
    if (std::fgets(text.data(), text.size(), file) != nullptr) children = text.data();
    std::fclose(file);
  }
  ::close(ends[0]);
  if (children.empty()) {
    ::kill(parent, SIGKILL);
    ::waitpid(parent, nullptr, 0);
    GTEST_SKIP() << "this kernel does not list the children of a process";
  }
  const pid_t grandchild = std::stoi(children);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  bool gone = false;
  for (int attempt = 0; attempt < 5000 && !gone; ++attempt) {
    gone = ::kill(grandchild, 0) != 0;
    // An orphan that nobody waits for stays in the table when it is dead.
    std::FILE* file =
        std::fopen(("/proc/" + children.substr(0, children.find(' ')) + "/stat").c_str(), "r");
    if (file != nullptr) {
      std::array<char, 256> text = {};
      if (std::fgets(text.data(), text.size(), file) != nullptr)
        gone = gone || std::string(text.data()).find(") Z") != std::string::npos;
      std::fclose(file);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(gone);
}

}  // namespace
}  // namespace tremolo
