/// What libFuzzer calls: one program per target, HAPTIC_FUZZ_TARGET names it.

#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string finding = haptic::test::HAPTIC_FUZZ_TARGET().run({data, size});
  if (finding.empty()) return 0;
  std::fprintf(stderr, "finding: %s\n", finding.c_str());
  std::abort();
}
