#include "server/front/net/tls_files.hpp"

#include <openssl/pem.h>
#include <openssl/x509.h>

#include <fstream>
#include <memory>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* object) const noexcept {
    kFree(object);
  }
};
using Memory = std::unique_ptr<BIO, Free<BIO_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;

/// Certificates and keys have some KB; a device or a wrong file must not fill the memory.
constexpr std::size_t kLargestFile = 1 << 20;

[[noreturn]] void refuse(const char* field, const std::filesystem::path& file,
                         const std::string& why) {
  throw core::TransportError("server.tls." + std::string(field) + " = '" + file.string() +
                             "': " + why);
}

std::string read(const char* field, const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) refuse(field, file, "cannot be read");
  std::string text(kLargestFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLargestFile) refuse(field, file, "has more than 1 MB: this is no PEM file");
  return text;
}

/// Its group may read it, as Debian's ssl-cert does; others may not, and only its owner may change
/// it.
void refuse_open_key(const std::filesystem::path& file) {
  using std::filesystem::perms;
  const perms open = perms::others_read | perms::others_write | perms::group_write;
  if ((std::filesystem::status(file).permissions() & open) == perms::none) return;
  refuse("key", file, "other users may read or change it: chmod 600, or 640 for a group");
}

Memory memory(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// For a key with a passphrase: none is given, and OpenSSL does not ask at the terminal.
int no_passphrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*user*/) {
  return -1;
}

Certificate first_certificate(const char* field, const std::filesystem::path& file,
                              const std::string& text) {
  Certificate certificate(PEM_read_bio_X509(memory(text).get(), nullptr, no_passphrase, nullptr));
  if (!certificate) refuse(field, file, "must hold a certificate as PEM");
  if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
    refuse(field, file, "is not valid yet: check the host's date");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
    refuse(field, file, "has expired");
  }
  return certificate;
}

}  // namespace

TlsFiles load_tls(const TlsConfig& config) {
  TlsFiles files;
  files.certificate = read("certificate", config.certificate);
  const Certificate certificate =
      first_certificate("certificate", config.certificate, files.certificate);
  files.key = read("key", config.key);
  const Key key(PEM_read_bio_PrivateKey(memory(files.key).get(), nullptr, no_passphrase, nullptr));
  if (!key) refuse("key", config.key, "must hold a private key as PEM, without a passphrase");
  refuse_open_key(config.key);
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    refuse("key", config.key, "must be that of the certificate");
  }
  if (!config.client_ca.empty()) {
    files.client_ca = read("client_ca", config.client_ca);
    static_cast<void>(first_certificate("client_ca", config.client_ca, files.client_ca));
  }
  return files;
}

}  // namespace haptic::server
