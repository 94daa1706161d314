#include "server/front/net/tls_files.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
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
using Context = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;

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

/// "2026-03-01 09:30 UTC"
std::string date(std::time_t at) {
  std::tm parts{};
  gmtime_r(&at, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts)};
}

std::time_t time_of(const ASN1_TIME* time) {
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1 ? timegm(&parts) : 0;
}

Certificate first_certificate(const Named& file, const std::string& text, TlsFiles& files) {
  Certificate certificate(PEM_read_bio_X509(memory(text).get(), nullptr, no_passphrase, nullptr));
  if (!certificate) file.refuse("must hold a certificate as PEM");
  if (X509_cmp_current_time(X509_get0_notBefore(certificate.get())) > 0) {
    file.refuse("is not valid before " + date(time_of(X509_get0_notBefore(certificate.get()))) +
                ": check the host's date");
  }
  files.ends.push_back({file.text, time_of(X509_get0_notAfter(certificate.get()))});
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
    file.refuse("has expired on " + date(files.ends.back().at));
  }
  return certificate;
}

/// OpenSSL refuses short keys and weak digests, and then no client would get in.
void check_strength(const Named& file, X509* certificate) {
  const Context context(SSL_CTX_new(TLS_server_method()));
  if (SSL_CTX_use_certificate(context.get(), certificate) == 1) return;
  const char* const why = ERR_reason_error_string(ERR_peek_last_error());
  file.refuse(std::string("OpenSSL refuses it: ") + (why == nullptr ? "no reason" : why));
}

}  // namespace

TlsFiles read_tls(const TlsConfig& config, std::span<const Descriptor> opened) {
  TlsFiles files;
  const Named certificate_file("certificate", config.certificate), key_file("key", config.key);
  files.certificate = read_named(certificate_file.text, opened[0]);
  const Certificate certificate = first_certificate(certificate_file, files.certificate, files);
  check_strength(certificate_file, certificate.get());
  files.key = read_named(key_file.text, opened[1]);
  const Key key(PEM_read_bio_PrivateKey(memory(files.key).get(), nullptr, no_passphrase, nullptr));
  if (!key) key_file.refuse("must hold a private key as PEM, without a passphrase");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    key_file.refuse("must be that of the certificate");
  }
  if (!config.client_ca.empty()) {
    const Named issuer_file("client_ca", config.client_ca);
    files.client_ca = read_named(issuer_file.text, opened[2]);
    static_cast<void>(first_certificate(issuer_file, files.client_ca, files));
  }
  return files;
}

std::vector<std::string> ending(const std::vector<CertificateEnd>& ends, std::time_t now) {
  constexpr std::time_t kDay = 24 * 3600, kSoon = 14 * kDay;
  std::vector<std::string> sentences;
  for (const CertificateEnd& end : ends) {
    if (end.at - now > kSoon) continue;
    const std::string when = end.at < now ? "has expired on " + date(end.at)
                                          : "expires on " + date(end.at) + ", in " +
                                                std::to_string((end.at - now) / kDay) + " days";
    sentences.push_back(end.name + ": " + when +
                        ": give a new one, then hapticctl restart-front; a front that starts after "
                        "its end is refused");
  }
  return sentences;
}

}  // namespace haptic::server
