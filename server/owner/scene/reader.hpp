#pragma once
/// Reads the fields of one message of a scene: fills in what is absent, in the message and in the
/// value it returns, and reports what is not allowed.

#include <google/protobuf/message.h>

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/time.hpp"
#include "server/owner/scene/problems.hpp"

namespace haptic::server {

/// Values that a number may have; always finite.
enum class Allowed : std::uint8_t { kFinite, kNotNegative, kPositive };

/// A list with one number per something.
struct ListField {
  const char* name;  ///< in scene.proto
  Allowed allowed;
  int size;         ///< how many there must be; -1: unknown, because what decides it is wrong
  const char* per;  ///< "coordinate", ...
};

/// An optional number and the value it stands for, which holds its default.
struct NumberField {
  const char* name;
  double* value;
  Allowed allowed;
};

struct DurationRange {
  core::Duration lowest{};
  core::Duration highest{};
};

template <typename Message>
class Part;

/// The fields of one message; `field` names one of them, "" the message itself.
class Fields {
 public:
  using Numbers = Eigen::VectorXd;

  /// `path` is the message's: "device[0].impedance". Files are relative to `folder`. `message`,
  /// `folder` and `problems` must outlive this.
  Fields(google::protobuf::Message& message, FieldPath path, const std::filesystem::path& folder,
         Problems& problems);

  [[nodiscard]] Problems& problems() const noexcept { return problems_; }
  /// Nothing was reported since this was made.
  [[nodiscard]] bool good() const noexcept { return problems_.count() == before_; }
  void wrong(const FieldStep& field, const std::string& value, const std::string& why) const;
  void missing(const FieldStep& field, const std::string& why) const;
  [[nodiscard]] FieldPath path(const FieldStep& field) const;

  /// The message in `field`, made if it is absent; those of a list.
  template <typename Child>
  [[nodiscard]] Part<Child> part(const std::string& field) const;
  template <typename Child>
  [[nodiscard]] std::vector<Part<Child>> parts(const std::string& list) const;
  /// The chosen field of a required oneof; reports that none is, with the choices there are, and
  /// returns "".
  [[nodiscard]] std::string choice(const std::string& oneof) const;

  /// Reads each number that is present; writes the default of each that is absent.
  void numbers(std::initializer_list<NumberField> fields) const;
  /// `fallback` replaces an empty list; without it the list is required. Empty if the size is
  /// wrong.
  [[nodiscard]] Numbers list(const ListField& field,
                             const std::optional<Numbers>& fallback = {}) const;
  /// The same with one value for each of the `n_a` actuated DoFs.
  [[nodiscard]] Numbers per_actuated(const char* name, Allowed allowed, int n_a,
                                     const std::optional<Numbers>& fallback = {}) const;
  /// The duration in `range`; `fallback` goes into the message if it is absent.
  [[nodiscard]] core::Duration duration(const std::string& field, core::Duration fallback,
                                        const DurationRange& range) const;
  /// The same without a default.
  [[nodiscard]] std::optional<core::Duration> duration(const std::string& field,
                                                       const DurationRange& range) const;
  /// The whole number from `lowest` to `highest`; `fallback` goes into the message if it is absent.
  [[nodiscard]] int whole_number(const std::string& field, int fallback, int lowest,
                                 int highest) const;
  /// Which of `words` the text is; an absent one becomes `fallback`, if there is one. Reports any
  /// other text, and returns 0.
  [[nodiscard]] std::size_t word(const std::string& field, const std::vector<std::string>& words,
                                 const std::string& fallback = {}) const;
  /// Reports `upper`, the value of `field`, unless it is above its lower limit.
  void above(const char* field, double upper, double lower) const;
  /// A file that is read, relative to the folder: its full path, which goes into the message. Empty
  /// if the field is; reports one that is not there: "must be `what`; there is none at ...".
  [[nodiscard]] std::filesystem::path file(const char* field, const std::string& what) const;
  /// The message's `name`, of a DoF, coordinate, joint or finger, which becomes a column of
  /// recordings. Reports unless it is 1 to `longest` letters, digits, _ and -, and not in `taken`,
  /// to which it is added.
  void entry_name(std::size_t longest, std::set<std::string>& taken) const;

  /// The result of `make`. If that throws SceneError, the error is reported at `field`, and the
  /// result is empty.
  template <typename Make>
  auto attempt(const FieldStep& field, const std::string& value, const Make& make) const
      -> decltype(make()) {
    try {
      return make();
    } catch (const core::SceneError& error) {
      wrong(field, value, error.what());
      return decltype(make())();
    }
  }

 protected:
  google::protobuf::Message& message_;

 private:
  [[nodiscard]] const google::protobuf::FieldDescriptor& find(const std::string& field) const;
  void check(const FieldStep& field, double value, Allowed allowed) const;

  FieldPath path_;
  const std::filesystem::path& folder_;
  Problems& problems_;
  std::size_t before_;
};

/// Fields of a message whose type is known: part->name() reads as of the message.
template <typename Message>
class Part : public Fields {
 public:
  using Fields::Fields;
  Message* operator->() const { return &dynamic_cast<Message&>(message_); }
};

template <typename Child>
Part<Child> Fields::part(const std::string& field) const {
  return {*message_.GetReflection()->MutableMessage(&message_, &find(field)), path(field), folder_,
          problems_};
}

template <typename Child>
std::vector<Part<Child>> Fields::parts(const std::string& list) const {
  const google::protobuf::Reflection& reflection = *message_.GetReflection();
  std::vector<Part<Child>> all;
  for (int i = 0; i < reflection.FieldSize(message_, &find(list)); ++i) {
    all.emplace_back(*reflection.MutableRepeatedMessage(&message_, &find(list), i),
                     path({list, static_cast<std::size_t>(i)}), folder_, problems_);
  }
  return all;
}

/// `value` n times; none if n < 0.
[[nodiscard]] inline Fields::Numbers filled(int n, double value) {
  return Fields::Numbers::Constant(std::max(n, 0), value);
}
/// "[1500, 1500]", or "[30 values]".
[[nodiscard]] std::string decimal(const Fields::Numbers& values);

}  // namespace haptic::server
