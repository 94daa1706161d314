#pragma once
/// The measuring rule of CONTRIBUTING.md#measuring: two programs in alternating blocks of one run,
/// the median of the paired ratios with its bootstrap 95 % interval, and an A/A row of the peer
/// against itself.

#include <functional>
#include <string>
#include <vector>

namespace haptic::bench {

/// Measures one block and returns its figure (ns per call, a percentile in us, ...).
using Block = std::function<double()>;

struct Ratio {
  double median{0.0};
  double lower{0.0}, upper{0.0};  ///< bootstrap 95 % interval of the median
};

/// The figure that is taken of a pair.
enum class Pairs { kRatio, kDifference };

struct Row {
  std::string what{};
  std::string against{};
  std::string unit{};
  double ours{0.0}, theirs{0.0};  ///< medians over the blocks
  Ratio own{};                    ///< of `ours`, no ratio: median and interval
  Ratio ratio{};                  ///< ours / theirs, or ours - theirs
  Ratio a_a{};                    ///< theirs and theirs, likewise
  double target{0.0};             ///< on that; 0: none
  Pairs pairs{Pairs::kRatio};
};

/// Runs ours, theirs and theirs again `blocks` (>= 20) times; the order turns every time.
[[nodiscard]] Row compare(const std::string& what, const std::string& against,
                          const std::string& unit, const Block& ours, const Block& theirs,
                          double target, int blocks = 24);

/// Several figures of one block, the same number in every block.
using Blocks = std::function<std::vector<double>()>;
/// The same for each figure; `what[i]` names the i-th. Without targets.
[[nodiscard]] std::vector<Row> compare_all(const std::vector<std::string>& what,
                                           const std::string& against, const std::string& unit,
                                           const Blocks& ours, const Blocks& theirs,
                                           int blocks = 24, Pairs pairs = Pairs::kRatio);

/// A figure without a peer: median over blocks with its interval.
struct Figure {
  std::string what{};
  std::string unit{};
  Ratio value{};
  double target{0.0};
};
[[nodiscard]] Figure measure(const std::string& what, const std::string& unit, const Block& block,
                             double target, int blocks = 24);

/// One CSV line each:
/// what,against,unit,ours,theirs,ratio,lower,upper,aa_lower,aa_upper,target,verdict. Verdict: "met"
/// or "missed" if the whole interval is, and the ratio is further from the target than the A/A
/// interval is wide; otherwise "not shown". Differences have "more" in place of "ratio".
void print_header(Pairs pairs = Pairs::kRatio);
void print(const Row& row);
void print(const Figure& figure);

/// Median time of one call in ns, over `calls` calls in one block.
[[nodiscard]] double ns_per_call(int calls, const std::function<void(int)>& body);
[[nodiscard]] inline Block ns_block(int calls, const std::function<void(int)>& body) {
  return [=] { return ns_per_call(calls, body); };
}

}  // namespace haptic::bench
