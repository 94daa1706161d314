#include "server/rpc/credentials.hpp"

#include <utility>

#include "server/net/tls_files.hpp"

namespace haptic::server {

Credentials::Credentials(const std::optional<TlsConfig>& tls, bool insecure_lab) {
  if (insecure_lab) best_ = Protection::kInsecureLab;
  if (!tls) return;
  TlsFiles files = load_tls(*tls);
  const bool mutual = !files.client_ca.empty();
  best_ = mutual ? Protection::kMutualTls : Protection::kTls;
  grpc::SslServerCredentialsOptions options(
      mutual ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
             : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  options.pem_root_certs = std::move(files.client_ca);
  options.pem_key_cert_pairs.push_back({std::move(files.key), std::move(files.certificate)});
  tls_ = grpc::SslServerCredentials(options);
}

std::shared_ptr<grpc::ServerCredentials> Credentials::of(Protection protection) const {
  const bool encrypted = protection == Protection::kTls || protection == Protection::kMutualTls;
  return encrypted ? tls_ : grpc::InsecureServerCredentials();
}

}  // namespace haptic::server
