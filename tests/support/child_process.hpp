#pragma once
/// A program that a test talks to, a line at a time. Ends with the test.

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

namespace haptic::test {

class ChildProcess {
 public:
  explicit ChildProcess(std::vector<std::string> command) {
    std::array<int, 2> to{}, from{};
    if (pipe2(to.data(), O_CLOEXEC) != 0 || pipe2(from.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe");
    }
    posix_spawn_file_actions_t streams;
    posix_spawn_file_actions_init(&streams);
    posix_spawn_file_actions_adddup2(&streams, to[0], 0);
    posix_spawn_file_actions_adddup2(&streams, from[1], 1);
    std::vector<char*> arguments;
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int failed =
        posix_spawn(&id_, arguments.front(), &streams, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&streams);
    close(to[0]);
    close(from[1]);
    in_ = fdopen(to[1], "w");
    out_ = fdopen(from[0], "r");
    if (failed != 0) throw std::runtime_error("no program " + command.front());
  }
  ~ChildProcess() {
    std::fclose(in_);
    std::fclose(out_);
    if (id_ > 0) {
      kill(id_, SIGTERM);
      waitpid(id_, nullptr, 0);
    }
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void write_line(const std::string& line) {
    std::fputs((line + "\n").c_str(), in_);
    std::fflush(in_);
  }
  /// Waits for it; empty if the program ended.
  [[nodiscard]] std::string read_line() {
    std::array<char, 4096> line{};
    if (std::fgets(line.data(), line.size(), out_) == nullptr) return {};
    return line.data();
  }

 private:
  pid_t id_{0};
  FILE* in_{nullptr};
  FILE* out_{nullptr};
};

}  // namespace haptic::test
