#include "tests/bench/paired.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "tests/support/csv.hpp"

namespace haptic::bench {

namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

Ratio with_interval(const std::vector<double>& values) {
  constexpr int kResamples = 2000;
  std::mt19937_64 random(1);
  std::vector<double> medians, sample(values.size());
  for (int i = 0; i < kResamples; ++i) {
    for (double& v : sample) v = values[random() % values.size()];
    medians.push_back(median(sample));
  }
  std::sort(medians.begin(), medians.end());
  return {median(values), medians[kResamples * 25 / 1000], medians[kResamples * 975 / 1000]};
}

/// CONTRIBUTING.md#measuring. `noise`: how far apart the same program is from itself.
const char* verdict(const Ratio& value, double target, double noise) {
  if (target <= 0.0) return "reported";
  const bool apart = std::abs(value.median - target) >= noise;
  if (apart && value.upper <= target) return "met";
  if (apart && value.lower > target) return "missed";
  return "not shown";
}

}  // namespace

Row compare(const std::string& what, const std::string& against, const std::string& unit,
            const Block& ours, const Block& theirs, double target, int blocks) {
  const auto as_list = [](const Block& block) {
    return [&block] { return std::vector<double>{block()}; };
  };
  Row row = compare_all({what}, against, unit, as_list(ours), as_list(theirs), blocks).front();
  row.target = target;
  return row;
}

std::vector<Row> compare_all(const std::vector<std::string>& what, const std::string& against,
                             const std::string& unit, const Blocks& ours, const Blocks& theirs,
                             int blocks, Pairs pairs) {
  const auto pair = [pairs](double mine, double their) {
    return pairs == Pairs::kRatio ? mine / their : mine - their;
  };
  using Values = std::vector<double>;
  static_cast<void>(ours());  // warm-up, not counted
  static_cast<void>(theirs());
  std::vector<Values> a(what.size()), b(what.size()), ratios(what.size()), a_a(what.size());
  for (int i = 0; i < blocks; ++i) {
    Values mine, first, second;
    if (i % 2 == 0) {
      mine = ours();
      first = theirs();
      second = theirs();
    } else {
      second = theirs();
      first = theirs();
      mine = ours();
    }
    for (std::size_t k = 0; k < what.size(); ++k) {
      a[k].push_back(mine.at(k));
      b[k].push_back(first.at(k));
      ratios[k].push_back(pair(mine.at(k), first.at(k)));
      a_a[k].push_back(pair(second.at(k), first.at(k)));
    }
  }
  std::vector<Row> rows;
  for (std::size_t k = 0; k < what.size(); ++k) {
    Row row{what[k], against, unit};
    row.own = with_interval(a[k]);
    row.ours = row.own.median;
    row.theirs = median(b[k]);
    row.ratio = with_interval(ratios[k]);
    row.a_a = with_interval(a_a[k]);
    row.pairs = pairs;
    rows.push_back(row);
  }
  return rows;
}

Figure measure(const std::string& what, const std::string& unit, const Block& block, double target,
               int blocks) {
  std::vector<double> values;
  static_cast<void>(block());
  for (int i = 0; i < blocks; ++i) values.push_back(block());
  return {what, unit, with_interval(values), target};
}

void print_header(Pairs pairs) {
  std::printf("what,against,unit,ours,theirs,%s,lower,upper,aa_lower,aa_upper,target,verdict\n",
              pairs == Pairs::kRatio ? "ratio" : "more");
}

void print(const Row& row) {
  const double same = row.pairs == Pairs::kRatio ? 1.0 : 0.0;
  std::printf("%s,%s,%s,%.4g,%.4g,%.3f,%.3f,%.3f,%.3f,%.3f,%.3g,%s\n",
              test::csv_field(row.what).c_str(), test::csv_field(row.against).c_str(),
              row.unit.c_str(), row.ours, row.theirs, row.ratio.median, row.ratio.lower,
              row.ratio.upper, row.a_a.lower, row.a_a.upper, row.target,
              verdict(row.ratio, row.target,
                      std::max(row.a_a.upper, same) - std::min(row.a_a.lower, same)));
  std::fflush(stdout);
}

void print(const Figure& figure) {
  std::printf("%s,-,%s,%.4g,,,%.4g,%.4g,,,%.4g,%s\n", test::csv_field(figure.what).c_str(),
              figure.unit.c_str(), figure.value.median, figure.value.lower, figure.value.upper,
              figure.target, verdict(figure.value, figure.target, 0.0));
  std::fflush(stdout);
}

double ns_per_call(int calls, const std::function<void(int)>& body) {
  // In eight stretches; the median of them sheds a stretch in which the machine did something else.
  constexpr int kStretches = 8;
  std::vector<double> stretches;
  const int each = std::max(1, calls / kStretches);
  for (int s = 0; s < kStretches; ++s) {
    const auto start = std::chrono::steady_clock::now();
    body(each);
    stretches.push_back(
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() /
        each);
  }
  return median(stretches);
}

}  // namespace haptic::bench
