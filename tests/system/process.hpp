#pragma once
/// A program of ours as a child process, ended by its id.

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <string>
#include <vector>

namespace haptic::test {

class Process {
 public:
  /// `standard_error`: where its words go; -1: to ours.
  Process(const std::string& program, std::vector<std::string> arguments, int standard_error = -1) {
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    id_ = fork();
    if (id_ == 0) {
      if (standard_error >= 0) dup2(standard_error, STDERR_FILENO);
      execv(program.c_str(), argv.data());
      _exit(127);
    }
  }
  ~Process() {
    signal(SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const {
    if (id_ > 0) ::kill(id_, number);
  }
  /// Exit code, or -1 where a signal ended it.
  int wait() {
    if (id_ <= 0) return code_;
    int status = 0;
    waitpid(id_, &status, 0);
    id_ = 0;
    return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t id_{0};
  int code_{-1};
};

}  // namespace haptic::test
