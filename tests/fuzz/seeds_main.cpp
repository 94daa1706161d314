/// haptic-fuzz-seeds FOLDER: writes the corpora that fuzzing begins with, FOLDER/TARGET/seed-N.

#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/fuzz/targets.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "haptic-fuzz-seeds FOLDER\n";
    return 2;
  }
  using namespace haptic::test;
  for (const FuzzTarget* target : {&datagram_target(), &ingress_target(), &scene_target()}) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / target->name;
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const FuzzBytes& seed : target->seeds()) {
      std::ofstream file(folder / ("seed-" + std::to_string(number++)), std::ios::binary);
      file.write(reinterpret_cast<const char*>(seed.data()),
                 static_cast<std::streamsize>(seed.size()));
      if (!file) {
        std::cerr << "haptic-fuzz-seeds: cannot write below " << folder << "\n";
        return 1;
      }
    }
  }
  return 0;
}
