#include "server/scene/reader.hpp"

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/reflection.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

using google::protobuf::FieldDescriptor;

std::string rule(double value, Allowed allowed) {
  const std::string finite = std::isfinite(value) ? "" : "finite and ";
  switch (allowed) {
    case Allowed::kFinite:
      return "must be finite";
    case Allowed::kNotNegative:
      return "must be " + finite + ">= 0";
    case Allowed::kPositive:
      return "must be " + finite + "> 0";
  }
  return {};
}

bool holds(double value, Allowed allowed) {
  if (!std::isfinite(value)) return false;
  return allowed == Allowed::kFinite || value > 0.0 ||
         (allowed == Allowed::kNotNegative && value == 0.0);
}

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
constexpr std::int64_t kLongest = 1'000'000;  // s; keeps nanoseconds far from overflow

/// Seconds and nanoseconds of one sign, each in its range.
bool is_valid(const google::protobuf::Duration& d) {
  return std::abs(d.seconds()) <= kLongest && std::abs(std::int64_t{d.nanos()}) < kNanosPerSecond &&
         (d.seconds() == 0 || d.nanos() == 0 || (d.seconds() > 0) == (d.nanos() > 0));
}

}  // namespace

FieldReader::FieldReader(google::protobuf::Message& message, std::string path, Problems& problems)
    : message_(message), path_(std::move(path)), problems_(problems) {}

std::string FieldReader::path(const std::string& field) const {
  return path_.empty() ? field : path_ + "." + field;
}

void FieldReader::wrong(const std::string& field, const std::string& value,
                        const std::string& why) const {
  problems_.wrong(path(field), value, why);
}

void FieldReader::missing(const std::string& field, const std::string& why) const {
  problems_.missing(path(field), why);
}

const FieldDescriptor& FieldReader::find(const std::string& field) const {
  return *message_.GetDescriptor()->FindFieldByName(field);
}

void FieldReader::check(const std::string& field, double value, Allowed allowed) const {
  if (!holds(value, allowed)) wrong(field, decimal(value), rule(value, allowed));
}

void FieldReader::numbers(std::initializer_list<NumberField> fields) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  for (const NumberField& number : fields) {
    const FieldDescriptor& field = find(number.name);
    if (!reflection.HasField(message_, &field)) {
      reflection.SetDouble(&message_, &field, *number.value);
      continue;
    }
    *number.value = reflection.GetDouble(message_, &field);
    check(number.name, *number.value, number.allowed);
  }
}

std::vector<double> FieldReader::list(const ListField& field,
                                      const std::optional<std::vector<double>>& fallback) const {
  auto entries =
      message_.GetReflection()->GetMutableRepeatedFieldRef<double>(&message_, &find(field.name));
  const std::string wanted = field.size < 0 ? std::string("one value per ") + field.per
                                            : "one value per " + std::string(field.per) + ", " +
                                                  std::to_string(field.size);
  if (entries.empty() && fallback) {
    for (const double value : *fallback) entries.Add(value);
  }
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(entries.size()));
  for (int i = 0; i < entries.size(); ++i) values.push_back(entries.Get(i));
  if (values.empty() && field.size != 0 && !fallback) missing(field.name, wanted);
  for (std::size_t i = 0; i < values.size(); ++i) {
    check(entry(field.name, i), values[i], field.allowed);
  }
  const bool fits = field.size < 0 || values.size() == static_cast<std::size_t>(field.size);
  if (!fits && !values.empty()) wrong(field.name, decimal(values), "must have " + wanted);
  return fits ? values : std::vector<double>{};
}

std::optional<core::Duration> FieldReader::duration(const std::string& field,
                                                    const DurationRange& range) const {
  if (!message_.GetReflection()->HasField(message_, &find(field))) return std::nullopt;
  const auto& given = static_cast<const google::protobuf::Duration&>(
      message_.GetReflection()->GetMessage(message_, &find(field)));
  const std::string allowed =
      "must be " + milliseconds(range.lowest) + " to " + milliseconds(range.highest);
  if (!is_valid(given)) {
    wrong(field,
          "{ seconds: " + std::to_string(given.seconds()) +
              " nanos: " + std::to_string(given.nanos()) + " }",
          allowed + ", seconds and nanos of one sign, nanos below 1e9");
    return std::nullopt;
  }
  const core::Duration value =
      std::chrono::seconds(given.seconds()) + core::Duration(given.nanos());
  if (value < range.lowest || value > range.highest) {
    wrong(field, milliseconds(value), allowed);
    return std::nullopt;
  }
  return value;
}

core::Duration FieldReader::duration(const std::string& field, core::Duration fallback,
                                     const DurationRange& range) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  if (reflection.HasField(message_, &find(field))) {
    return duration(field, range).value_or(fallback);
  }
  auto& absent =
      static_cast<google::protobuf::Duration&>(*reflection.MutableMessage(&message_, &find(field)));
  absent.set_seconds(fallback.count() / kNanosPerSecond);
  absent.set_nanos(static_cast<std::int32_t>(fallback.count() % kNanosPerSecond));
  return fallback;
}

void FieldReader::whole_number(const std::string& field, std::int64_t value, std::int64_t lowest,
                               std::int64_t highest) const {
  if (value >= lowest && value <= highest) return;
  wrong(field, std::to_string(value),
        "must be " + std::to_string(lowest) + " to " + std::to_string(highest));
}

std::filesystem::path FieldReader::file(const char* field, const std::filesystem::path& folder,
                                        const std::string& what) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  const std::string given = reflection.GetString(message_, &find(field));
  if (given.empty()) return {};
  const std::filesystem::path full = std::filesystem::absolute(folder / given).lexically_normal();
  std::error_code unreadable;
  if (!std::filesystem::is_regular_file(full, unreadable)) {
    wrong(field, quoted(given), "must be " + what + "; there is none at " + full.string());
  }
  reflection.SetString(&message_, &find(field), full.string());
  return full;
}

void FieldReader::entry_name(std::size_t longest, std::set<std::string>& taken) const {
  const std::string name = message_.GetReflection()->GetString(message_, &find("name"));
  const bool well_formed = !name.empty() && name.size() <= longest &&
                           std::all_of(name.begin(), name.end(), [](unsigned char c) {
                             return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-');
                           });
  if (!well_formed) {
    wrong("name", quoted(name),
          "must be 1 to " + std::to_string(longest) + " of letters, digits, _ and -");
  } else if (!taken.insert(name).second) {
    wrong("name", quoted(name), "must be another: this one is taken");
  }
}

core::VecQ to_vector(const std::vector<double>& values) {
  if (values.size() > static_cast<std::size_t>(core::kMaxQ)) return {};
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::string decimal(const std::vector<double>& values) {
  constexpr std::size_t kMost = 8;
  if (values.size() > kMost) return "[" + std::to_string(values.size()) + " values]";
  std::string all;
  for (const double value : values) all += (all.empty() ? "" : ", ") + decimal(value);
  return "[" + all + "]";
}

}  // namespace haptic::server
