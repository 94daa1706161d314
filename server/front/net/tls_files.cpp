#include "server/front/net/tls_files.hpp"

#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>

#include "haptic/core/error.hpp"
#include "server/front/net/named_file.hpp"

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

/// A file of the scene by its name.
struct Named {
  Named(const char* field, const std::filesystem::path& file)
      : text("server.tls." + std::string(field) + " = '" + file.string() + "'") {}
  [[noreturn]] void refuse(const std::string& why) const {
    throw core::TransportError(text + ": " + why);
  }
  const std::string text;
};

Memory memory(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// For a key with a passphrase: none is given, and OpenSSL does not ask at the terminal.
int no_passphrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*user*/) {
  return -1;
}

Certificate first_certificate(const Named& file, const std::string& text) {
  Certificate certificate(PEM_read_bio_X509(memory(text).get(), nullptr, no_passphrase, nullptr));
  if (!certificate) file.refuse("must hold a certificate as PEM");
  if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
    file.refuse("is not valid yet: check the host's date");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
    file.refuse("has expired");
  }
  return certificate;
}

}  // namespace

TlsFiles read_tls(const TlsConfig& config, std::span<const Descriptor> opened) {
  TlsFiles files;
  const Named certificate_file("certificate", config.certificate), key_file("key", config.key);
  files.certificate = read_named(certificate_file.text, opened[0]);
  const Certificate certificate = first_certificate(certificate_file, files.certificate);
  files.key = read_named(key_file.text, opened[1]);
  const Key key(PEM_read_bio_PrivateKey(memory(files.key).get(), nullptr, no_passphrase, nullptr));
  if (!key) key_file.refuse("must hold a private key as PEM, without a passphrase");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    key_file.refuse("must be that of the certificate");
  }
  if (!config.client_ca.empty()) {
    const Named issuer_file("client_ca", config.client_ca);
    files.client_ca = read_named(issuer_file.text, opened[2]);
    static_cast<void>(first_certificate(issuer_file, files.client_ca));
  }
  return files;
}

}  // namespace haptic::server
