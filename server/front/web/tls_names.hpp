#pragma once
/// TLS of the web (private to server/front/web).

#include <openssl/ssl.h>

#include <string>
#include <vector>

namespace haptic::server {

/// The names in the certificate that the far end showed and that was verified: the subject
/// alternative names, else the common name. Empty: it showed none.
[[nodiscard]] std::vector<std::string> certificate_names(const SSL* connection);

}  // namespace haptic::server
