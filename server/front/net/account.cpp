#include "server/front/net/account.hpp"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

namespace haptic::server {

Traffic traffic_of(int socket, const Account& account) {
  Traffic now;
  now.understood = account.understood();
  now.messages = account.messages();
  tcp_info info{};
  socklen_t size = sizeof info;
  int unread = 0;
  int unsent = 0;
  if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 ||
      ioctl(socket, SIOCINQ, &unread) != 0 || ioctl(socket, SIOCOUTQ, &unsent) != 0) {
    return now;
  }
  const auto waiting = static_cast<std::uint64_t>(std::max(unread, 0));
  now.received =
      info.tcpi_bytes_received - std::min<std::uint64_t>(waiting, info.tcpi_bytes_received);
  now.unread = static_cast<std::uint64_t>(std::max(unsent, 0));
  now.acknowledged = info.tcpi_bytes_acked;
  return now;
}

}  // namespace haptic::server
