#include "server/owner/scene/reader.hpp"

#include <google/protobuf/duration.pb.h>
#include <google/protobuf/reflection.h>

#include <cmath>

#include "haptic/core/types.hpp"
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

Fields::Fields(google::protobuf::Message& message, FieldPath path,
               const std::filesystem::path& folder, Problems& problems)
    : message_(message),
      path_(std::move(path)),
      folder_(folder),
      problems_(problems),
      before_(problems.count()) {}

FieldPath Fields::path(const FieldStep& field) const {
  FieldPath whole = path_;
  if (!field.name.empty()) whole.push_back(field);
  return whole;
}

void Fields::wrong(const FieldStep& field, const std::string& value, const std::string& why) const {
  problems_.wrong(path(field), value, why);
}

void Fields::missing(const FieldStep& field, const std::string& why) const {
  problems_.missing(path(field), why);
}

const FieldDescriptor& Fields::find(const std::string& field) const {
  return *message_.GetDescriptor()->FindFieldByName(field);
}

void Fields::check(const FieldStep& field, double value, Allowed allowed) const {
  if (!holds(value, allowed)) wrong(field, decimal(value), rule(value, allowed));
}

void Fields::numbers(std::initializer_list<NumberField> fields) const {
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

std::string Fields::choice(const std::string& oneof) const {
  const auto* const choices = message_.GetDescriptor()->FindOneofByName(oneof);
  const auto* const chosen = message_.GetReflection()->GetOneofFieldDescriptor(message_, choices);
  if (chosen != nullptr) return chosen->name();
  std::string all;
  for (int i = 0; i < choices->field_count(); ++i) {
    all += (i == 0 ? "one of " : ", ") + choices->field(i)->name();
  }
  missing(oneof, all);
  return {};
}

Fields::Numbers Fields::list(const ListField& field, const std::optional<Numbers>& fallback) const {
  auto entries =
      message_.GetReflection()->GetMutableRepeatedFieldRef<double>(&message_, &find(field.name));
  const std::string wanted = std::string("one value per ") + field.per +
                             (field.size < 0 ? "" : ", " + std::to_string(field.size));
  if (entries.empty() && fallback) {
    for (const double value : *fallback) entries.Add(value);
  }
  Numbers values(entries.size());
  for (int i = 0; i < entries.size(); ++i) {
    values[i] = entries.Get(i);
    check({field.name, static_cast<std::size_t>(i)}, values[i], field.allowed);
  }
  if (entries.empty() && field.size != 0 && !fallback) missing(field.name, wanted);
  if (field.size < 0) return entries.size() <= core::kMaxQ ? values : Numbers();
  if (entries.size() == field.size) return values;
  if (!entries.empty()) wrong(field.name, decimal(values), "must have " + wanted);
  return {};
}

Fields::Numbers Fields::per_actuated(const char* name, Allowed allowed, int n_a,
                                     const std::optional<Numbers>& fallback) const {
  return list({name, allowed, n_a, "actuated DoF"}, fallback);
}

std::optional<core::Duration> Fields::duration(const std::string& field,
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

core::Duration Fields::duration(const std::string& field, core::Duration fallback,
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

int Fields::whole_number(const std::string& field, int fallback, int lowest, int highest) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  const FieldDescriptor& its = find(field);
  const bool is_signed = its.cpp_type() == FieldDescriptor::CPPTYPE_INT32;
  if (!reflection.HasField(message_, &its)) {
    if (is_signed) {
      reflection.SetInt32(&message_, &its, fallback);
    } else {
      reflection.SetUInt32(&message_, &its, static_cast<std::uint32_t>(fallback));
    }
  }
  const std::int64_t value = is_signed ? std::int64_t{reflection.GetInt32(message_, &its)}
                                       : std::int64_t{reflection.GetUInt32(message_, &its)};
  if (value < lowest || value > highest) {
    wrong(field, std::to_string(value),
          "must be " + std::to_string(lowest) + " to " + std::to_string(highest));
  }
  return static_cast<int>(value);
}

std::size_t Fields::word(const std::string& field, const std::vector<std::string>& words,
                         const std::string& fallback) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  if (reflection.GetString(message_, &find(field)).empty()) {
    reflection.SetString(&message_, &find(field), fallback);
  }
  const std::string text = reflection.GetString(message_, &find(field));
  std::string allowed;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (text == words[i]) return i;
    allowed += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + quoted(words[i]);
  }
  wrong(field, quoted(text), "must be " + allowed);
  return 0;
}

void Fields::above(const char* field, double upper, double lower) const {
  if (upper > lower) return;
  wrong(field, decimal(upper), "must be above its lower limit, " + decimal(lower));
}

std::filesystem::path Fields::file(const char* field, const std::string& what) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  const std::string given = reflection.GetString(message_, &find(field));
  if (given.empty()) return {};
  const std::filesystem::path full = std::filesystem::absolute(folder_ / given).lexically_normal();
  std::error_code unreadable;
  if (!std::filesystem::is_regular_file(full, unreadable)) {
    wrong(field, quoted(given), "must be " + what + "; there is none at " + full.string());
  }
  reflection.SetString(&message_, &find(field), full.string());
  return full;
}

void Fields::entry_name(std::size_t longest, std::set<std::string>& taken) const {
  const std::string name = message_.GetReflection()->GetString(message_, &find("name"));
  if (!matches(name, "[A-Za-z0-9_-]{1," + std::to_string(longest) + "}")) {
    wrong("name", quoted(name),
          "must be 1 to " + std::to_string(longest) + " of letters, digits, _ and -");
  } else if (!taken.insert(name).second) {
    wrong("name", quoted(name), "must be another: this one is taken");
  }
}

std::string decimal(const Fields::Numbers& values) {
  constexpr Eigen::Index kMost = 8;
  if (values.size() > kMost) return "[" + std::to_string(values.size()) + " values]";
  std::string all;
  for (const double value : values) all += (all.empty() ? "" : ", ") + decimal(value);
  return "[" + all + "]";
}

}  // namespace haptic::server
