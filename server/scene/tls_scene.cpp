#include "server/scene/tls_scene.hpp"

#include <set>

#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

/// The full path of a file; empty where the scene names none.
fs::path find_file(const std::string& file, const fs::path& folder, const char* field,
                   const FieldReader& reader) {
  if (file.empty()) return {};
  fs::path full = fs::absolute(folder / file).lexically_normal();
  std::error_code unreadable;
  if (!fs::is_regular_file(full, unreadable)) {
    reader.wrong(field, quoted(file), "must be a PEM file; there is none at " + full.string());
  }
  return full;
}

Priority read_priority(const std::string& text, const FieldReader& reader) {
  for (const Priority priority : {Priority::kTest, Priority::kPrimary, Priority::kOperator}) {
    if (text == name(priority)) return priority;
  }
  reader.wrong("highest_priority", quoted(text), R"(must be "test", "primary" or "operator")");
  return Priority::kTest;
}

}  // namespace

TlsConfig read_tls(v1::TlsScene& message, const fs::path& folder, Problems& problems) {
  const FieldReader reader(message, "server.tls", problems);
  TlsConfig tls;
  if (message.certificate().empty()) reader.missing("certificate", "the name of a PEM file");
  if (message.key().empty()) reader.missing("key", "the name of a PEM file");
  tls.certificate = find_file(message.certificate(), folder, "certificate", reader);
  tls.key = find_file(message.key(), folder, "key", reader);
  tls.client_ca = find_file(message.client_ca(), folder, "client_ca", reader);
  message.set_certificate(tls.certificate.string());
  message.set_key(tls.key.string());
  if (!tls.client_ca.empty()) message.set_client_ca(tls.client_ca.string());
  std::set<std::string> names;
  for (int i = 0; i < message.client_size(); ++i) {
    v1::TlsClientScene& client = *message.mutable_client(i);
    const FieldReader entry(client, "server.tls.client[" + std::to_string(i) + "]", problems);
    if (client.name().empty()) entry.missing("name", "one of its certificate");
    if (!names.insert(client.name()).second) {
      entry.wrong("name", quoted(client.name()), "must be another: this one is listed already");
    }
    if (tls.client_ca.empty()) {
      entry.wrong("name", quoted(client.name()), "needs server.tls.client_ca: who is it else?");
    }
    tls.clients.push_back({client.name(), read_priority(client.highest_priority(), entry)});
  }
  return tls;
}

}  // namespace haptic::server
