#include "discovery/announced.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace haptic::ctl {
namespace {

/// Takes the next byte of text in DNS's notation: "\059", "\"" or the byte itself.
char next_byte(std::string_view& text) {
  const auto digit = [&](std::size_t i) { return i < text.size() ? text[i] - '0' : -1; };
  const auto is_digit = [&](std::size_t i) { return digit(i) >= 0 && digit(i) <= 9; };
  std::size_t used = 1;
  char byte = text[0];
  if (byte == '\\' && is_digit(1) && is_digit(2) && is_digit(3)) {
    byte = static_cast<char>(digit(1) * 100 + digit(2) * 10 + digit(3));
    used = 4;
  } else if (byte == '\\' && text.size() > 1) {
    byte = text[1];
    used = 2;
  }
  text.remove_prefix(used);
  return byte;
}

std::string unescaped(std::string_view text) {
  std::string bytes;
  while (!text.empty()) bytes += next_byte(text);
  return bytes;
}

/// "\"a=1\" \"b=2\"" as its strings.
std::vector<std::string> strings(std::string_view text) {
  std::vector<std::string> all;
  while (!text.empty()) {
    if (text[0] != '"') {
      text.remove_prefix(1);
      continue;
    }
    text.remove_prefix(1);
    std::string& one = all.emplace_back();
    while (!text.empty() && text[0] != '"') one += next_byte(text);
    if (!text.empty()) text.remove_prefix(1);
  }
  return all;
}

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= 65535;
}

}  // namespace

std::optional<Announced> announced(std::string_view line) {
  // "=", interface, protocol, name, type, domain, host, address, port, TXT, which may have a ";".
  std::array<std::string_view, 10> field{};
  for (std::size_t i = 0; i < field.size(); ++i) {
    const std::size_t end = i + 1 < field.size() ? line.find(';') : line.size();
    if (end == std::string_view::npos) return std::nullopt;
    field[i] = line.substr(0, end);
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  const auto& [kind, interface, protocol, name, type, domain, host, address, port, txt] = field;
  if (kind != "=" || !is_port(port)) return std::nullopt;
  const std::string ip(address);
  std::array<unsigned char, sizeof(in6_addr)> parsed{};
  std::string server;
  if (inet_pton(AF_INET, ip.c_str(), parsed.data()) == 1) {
    server = ip;
  } else if (inet_pton(AF_INET6, ip.c_str(), parsed.data()) == 1) {
    const bool link_local = parsed[0] == 0xFE && (parsed[1] & 0xC0) == 0x80;
    server = "[" + ip + (link_local ? "%" + std::string(interface) : "") + "]";
  } else {
    return std::nullopt;
  }
  return Announced{unescaped(name), unescaped(host), server + ":" + std::string(port),
                   strings(txt)};
}

}  // namespace haptic::ctl
