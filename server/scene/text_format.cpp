#include "server/scene/text_format.hpp"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <vector>

#include "haptic/core/error.hpp"

namespace haptic::server {

namespace {

/// Levenshtein's distance.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j < row.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// The n-th quoted word of a message of protobuf's parser.
std::string quoted(const std::string& message, int n) {
  std::size_t from = 0;
  for (int i = 0; i <= 2 * n; ++i) {
    from = message.find('"', from);
    if (from == std::string::npos) return {};
    ++from;
  }
  return message.substr(from, message.find('"', from) - from);
}

class Collector final : public google::protobuf::io::ErrorCollector {
 public:
  explicit Collector(std::string name) : name_(std::move(name)) {}

  void AddError(int line, int column, const std::string& message) override {
    std::string hint;
    if (message.find("has no field named") != std::string::npos) {
      const auto* type = google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(
          quoted(message, 0));
      if (type != nullptr) hint = " Allowed here: " + fields_of(*type, quoted(message, 1)) + ".";
    }
    text += (text.empty() ? "" : "\n") + name_ + ":" + std::to_string(line + 1) + ":" +
            std::to_string(column + 1) + ": " + message + hint;
  }

  std::string text{};

 private:
  std::string name_;
};

}  // namespace

std::string fields_of(const google::protobuf::Descriptor& type, const std::string& wanted) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  std::stable_sort(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
    return distance(a, wanted) < distance(b, wanted);
  });
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "no fields at all" : all;
}

void parse_text(const std::string& text, const std::string& name, v1::Scene& message,
                google::protobuf::TextFormat::ParseInfoTree& tree) {
  Collector collector(name);
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&tree);
  parser.SetRecursionLimit(32);
  google::protobuf::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
  if (!parser.Parse(&stream, &message)) {
    throw core::SceneError(collector.text.empty() ? name + ": not a scene" : collector.text);
  }
}

}  // namespace haptic::server
