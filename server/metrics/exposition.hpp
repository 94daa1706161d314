#pragma once
/// Prometheus' text exposition format 0.0.4: what a scrape answers with.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace haptic::server {

/// Values counted by upper bounds. Not thread-safe.
class Histogram {
 public:
  /// `bounds`: ascending; what is above the last goes to +Inf. The array must outlive this.
  explicit Histogram(std::span<const double> bounds)
      : bounds_(bounds), counts_(bounds.size() + 1, 0) {}

  void add(double value) noexcept;
  [[nodiscard]] std::span<const double> bounds() const noexcept { return bounds_; }
  /// Values in (bound i - 1, bound i]; the last entry is what is above all.
  [[nodiscard]] const std::vector<std::uint64_t>& counts() const noexcept { return counts_; }
  [[nodiscard]] double sum() const noexcept { return sum_; }

 private:
  std::span<const double> bounds_;
  std::vector<std::uint64_t> counts_;
  double sum_{0.0};
};

class Exposition {
 public:
  using Label = std::pair<std::string_view, std::string_view>;
  using Labels = std::vector<Label>;

  /// Each begins a family; the samples that follow are its.
  void counter(std::string_view name, std::string_view help) { family(name, "counter", help); }
  void gauge(std::string_view name, std::string_view help) { family(name, "gauge", help); }
  void histogram(std::string_view name, std::string_view help) { family(name, "histogram", help); }

  void sample(const Labels& labels, double value) { line("", labels, value); }
  void sample(const Labels& labels, const Histogram& values);

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  void family(std::string_view name, std::string_view type, std::string_view help);
  void line(std::string_view suffix, const Labels& labels, double value);

  std::string text_{};
  std::string name_{};
};

}  // namespace haptic::server
