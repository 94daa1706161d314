#pragma once
/// The steps that every function of haptic.h shares: find the object of a handle, catch every
/// exception, report the error.

#include <cxxabi.h>

#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "haptic/client/client.hpp"
#include "haptic/haptic.h"
#include "structs.hpp"

namespace haptic::c {

/// Throws kClosed in a child of the process that connected first: the library's threads are its
/// parent's, and so are the connections.
void refuse_in_a_child();

/// A session, and its events until they are asked for.
class Session {
 public:
  static constexpr std::size_t kMostEvents = 256;

  /// Throws as client::Connection::open() does, and if the device is larger than haptic_state.
  Session(client::Connection& connection, client::SessionOptions options);
  [[nodiscard]] client::Session& operator*() const { return *session_; }
  [[nodiscard]] client::Session* operator->() const { return session_.get(); }
  /// HAPTIC_OK or HAPTIC_NOTHING.
  int next_event(haptic_event& event);
  /// Throws kInvalidArgument if it is of another role, and kClosed if the session ended.
  void check_publisher(bool of_poses);
  [[nodiscard]] std::size_t coordinates() const { return session_->device().coordinates.size(); }

 private:
  void keep(haptic_event event, const std::string& reason, const std::string& message);

  const bool observer_, tracker_;
  std::mutex mutex_{};
  std::deque<haptic_event> events_{};
  std::uint64_t lost_{0};
  std::optional<client::ClientError> ended_{};
  std::unique_ptr<client::Session> session_{};  ///< ends first: its callbacks use the others
};

/// A handle is a number, and this table has its object. A call keeps its object alive even if
/// another thread closes the handle meanwhile.
template <typename Handle, typename Object>
class Handles {
 public:
  /// Tables that begin at different numbers below 16 have no number in common.
  explicit Handles(std::uintptr_t first) : next_(first) {}
  Handle* add(std::shared_ptr<Object> object) {
    const std::lock_guard lock(mutex_);
    next_ += 16;  // never 0
    objects_.emplace(next_, std::move(object));
    return reinterpret_cast<Handle*>(next_);
  }
  [[nodiscard]] std::shared_ptr<Object> find(Handle* handle) {
    refuse_in_a_child();  // another thread may hold the lock for ever
    const std::lock_guard lock(mutex_);
    return objects_.at(checked(handle));
  }
  [[nodiscard]] std::shared_ptr<Object> take(Handle* handle) {
    refuse_in_a_child();
    const std::lock_guard lock(mutex_);
    return std::move(objects_.extract(checked(handle)).mapped());
  }

  [[nodiscard]] std::vector<std::shared_ptr<Object>> take_all() {
    std::vector<std::shared_ptr<Object>> all;
    const std::lock_guard lock(mutex_);
    for (auto& [number, object] : objects_) all.push_back(std::move(object));
    objects_.clear();
    return all;
  }

 private:
  std::uintptr_t checked(Handle* handle) const {
    const auto number = reinterpret_cast<std::uintptr_t>(handle);
    if (objects_.count(number) == 0) {
      throw client::ClientError(client::ErrorReason::kClosed,
                                "the handle is NULL, closed, or not one of this library");
    }
    return number;
  }

  std::mutex mutex_{};
  std::unordered_map<std::uintptr_t, std::shared_ptr<Object>> objects_{};
  std::uintptr_t next_;
};

/// Never destroyed: at exit() gRPC's own statics may be gone before these.
Handles<haptic_connection, client::Connection>& connections();
Handles<haptic_session, Session>& sessions();

/// Writes into `error`, if there is one, and returns `code`.
int report(haptic_error* error, int code, const char* message,
           const char* server_reason = "") noexcept;
int report(haptic_error* error, const client::ClientError& why) noexcept;

/// `body` returns nothing, or a code that is no error.
template <typename Body>
int guarded(haptic_error* error, Body body) {
  try {
    if constexpr (std::is_void_v<decltype(body())>) {
      body();
      return report(error, HAPTIC_OK, "");
    } else {
      return report(error, body(), "");
    }
  } catch (const client::ClientError& why) {
    return report(error, why);
  } catch (const std::out_of_range& why) {
    return report(error, HAPTIC_ERROR_INVALID_ARGUMENT, why.what());
  } catch (const std::invalid_argument& why) {
    return report(error, HAPTIC_ERROR_INVALID_ARGUMENT, why.what());
  } catch (const std::bad_alloc&) {
    return report(error, HAPTIC_ERROR_NO_MEMORY, "out of memory");
  } catch (const std::exception& why) {
    return report(error, HAPTIC_ERROR_INTERNAL, why.what());
  } catch (const abi::__forced_unwind&) {
    throw;  // pthread_exit() in a caller's function, as Python's threads end with Python
  } catch (...) {
    return report(error, HAPTIC_ERROR_INTERNAL, "an exception without a name");
  }
}

}  // namespace haptic::c
