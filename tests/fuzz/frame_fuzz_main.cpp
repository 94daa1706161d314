/// haptic-fuzz-frames [EXECUTIONS [SEED]]: default 10 million, seed 1. Exit status 1 at a finding.

#include <cstdio>
#include <cstdlib>

#include "fuzz/frame_fuzz.hpp"

int main(int argc, char** argv) {
  const std::uint64_t executions = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const haptic::test::FuzzResult result = haptic::test::fuzz_frames(seed, executions);
  std::printf("%llu executions: %llu frames read, %llu bad CRC, %llu malformed; finding: %s\n",
              static_cast<unsigned long long>(result.executions),
              static_cast<unsigned long long>(result.frames),
              static_cast<unsigned long long>(result.bad_crc),
              static_cast<unsigned long long>(result.malformed),
              result.finding.empty() ? "none" : result.finding.c_str());
  return result.finding.empty() ? 0 : 1;
}
