#pragma once
/// Where the local control socket is reached: UNIX sockets of type SOCK_SEQPACKET, for each name
///
///   FOLDER/NAME        root and the user that runs hapticd alone, by the file's rights: no other
///                      user's flood reaches it
///   FOLDER/NAME.all    every user who may enter the folder
///   @hapticd/NAME      every user of this host, also if there is no folder. The first process that
///                      asks for such a name has it, so hapticd only needs it if there is no folder

#include <string>
#include <vector>

#include "server/base/descriptor.hpp"

namespace haptic::server {

struct ControlPlaces {
  std::string folder{};              ///< empty: none
  std::vector<std::string> names{};  ///< as haptic::wire::control_names() gives them
};

/// The folder that no other user can change, made if need be: /run/hapticd for root and for its
/// owner (systemd makes it for the service), else hapticd/ in the user's runtime folder. Empty:
/// there is none.
[[nodiscard]] std::string control_folder();

class ControlListeners {
 public:
  struct Listener {
    Descriptor socket{};
    bool for_all{true};
  };

  /// Binds. Throws core::TransportError: another hapticd has a name, or without a folder any
  /// program has one; or none can be bound.
  explicit ControlListeners(const ControlPlaces& places);
  /// Removes the files.
  ~ControlListeners();
  ControlListeners(const ControlListeners&) = delete;
  ControlListeners& operator=(const ControlListeners&) = delete;

  [[nodiscard]] const std::vector<Listener>& all() const noexcept { return listeners_; }

 private:
  void bind_file(const std::string& path, bool for_all);
  /// False: it is taken.
  [[nodiscard]] bool bind_abstract(const std::string& name);

  std::vector<Listener> listeners_{};
  std::vector<std::string> files_{};
};

}  // namespace haptic::server
