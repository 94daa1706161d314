#pragma once
/// Prometheus' text exposition format 0.0.4: what a scrape answers with.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/crossing/tick_totals.hpp"

namespace haptic::server {

class Exposition {
 public:
  using Label = std::pair<std::string_view, std::string_view>;
  using Labels = std::vector<Label>;

  /// Each begins a family; the samples that follow are its.
  void counter(std::string_view name, std::string_view help) { family(name, "counter", help); }
  void gauge(std::string_view name, std::string_view help) { family(name, "gauge", help); }
  void histogram(std::string_view name, std::string_view help) { family(name, "histogram", help); }

  void sample(const Labels& labels, double value) { line("", labels, value); }
  void sample(const Labels& labels, const HistogramView& values);

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  void family(std::string_view name, std::string_view type, std::string_view help);
  void line(std::string_view suffix, const Labels& labels, double value);

  std::string text_{};
  std::string name_{};
};

}  // namespace haptic::server
