#include "server/front/web/json.hpp"

#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver_util.h>
#include <openssl/evp.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "google/rpc/error_details.pb.h"
#include "server/front/service/rich_status.hpp"
#include "server/front/session/refusals.hpp"

namespace haptic::server {
namespace {

constexpr char kTypeHost[] = "type.googleapis.com";
constexpr std::size_t kLongestWhy = 300;
constexpr int kDeepest = 32;  // brackets within brackets; messages have fewer than ten

struct CodeWords {
  Refusal::Code code;
  unsigned status;
  const char* word;
};

constexpr CodeWords kCodes[] = {{Refusal::Code::kInvalid, 400, "invalid_argument"},
                                {Refusal::Code::kNotFound, 404, "not_found"},
                                {Refusal::Code::kExists, 409, "already_exists"},
                                {Refusal::Code::kPermission, 403, "permission_denied"},
                                {Refusal::Code::kExhausted, 429, "resource_exhausted"},
                                {Refusal::Code::kPrecondition, 400, "failed_precondition"},
                                {Refusal::Code::kAborted, 409, "aborted"},
                                {Refusal::Code::kUnavailable, 503, "unavailable"},
                                {Refusal::Code::kUnauthenticated, 401, "unauthenticated"}};

CodeWords words_of(Refusal::Code code) noexcept {
  for (const CodeWords& words : kCodes) {
    if (words.code == code) return words;
  }
  return {code, 500, "internal"};
}

/// True if brackets nest deeper than kDeepest, as far as `text` is JSON. protobuf bounds objects in
/// objects, but not arrays in arrays: 64 KB of those cost it 30 ms and 20 MB.
bool too_deep(std::string_view text) noexcept {
  int depth = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != 0) {
      if (c == '\\') ++i;
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {  // protobuf reads either
      quote = c;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepest) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

/// Without padding, as Connect has it.
std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                   reinterpret_cast<const unsigned char*>(bytes.data()),
                                   static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(size));
  while (text.ends_with('=')) text.pop_back();
  return text;
}

}  // namespace

Json::Json()
    : types_(google::protobuf::util::NewTypeResolverForDescriptorPool(
          kTypeHost, google::protobuf::DescriptorPool::generated_pool())) {}

std::string Json::from_bytes(const google::protobuf::Descriptor& type,
                             const std::string& bytes) const {
  std::string text;
  // Bytes of this server's own making: there is nothing that it could not say.
  static_cast<void>(google::protobuf::util::BinaryToJsonString(
      types_.get(), std::string(kTypeHost) + "/" + type.full_name(), bytes, &text));
  return text;
}

std::string Json::from_message(const google::protobuf::Message& message) {
  std::string text;
  static_cast<void>(google::protobuf::util::MessageToJsonString(message, &text));
  return text;
}

std::string Json::read(std::string_view text, google::protobuf::Message& message) {
  message.Clear();
  const std::string not_one = "not a " + message.GetDescriptor()->name() + " as JSON: ";
  if (too_deep(text)) {
    return not_one + "brackets are nested deeper than " + std::to_string(kDeepest);
  }
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;  // proto/README.md#how-it-may-change
  const auto status = google::protobuf::util::JsonStringToMessage(
      google::protobuf::StringPiece(text.data(), text.size()), &message, options);
  if (status.ok()) return {};
  const auto why = status.message();
  return sanitised(not_one + std::string(why.data(), why.size()), kLongestWhy);
}

std::string Json::read(const std::string& body, bool json, google::protobuf::Message& message) {
  if (json) return read(body, message);
  return message.ParseFromString(body) ? "" : "not a " + message.GetDescriptor()->name();
}

unsigned http_status(Refusal::Code code) noexcept {
  return words_of(code).status;
}

std::string connect_error(const Refusal& refusal) {
  nlohmann::json error;
  error["code"] = words_of(refusal.code).word;
  error["message"] = refusal.message.str();
  error["details"] = nlohmann::json::array();
  const google::rpc::Status status = rich_status(refusal);
  for (const auto& detail : status.details()) {
    nlohmann::json entry;
    entry["type"] = detail.type_url().substr(detail.type_url().rfind('/') + 1);
    entry["value"] = base64(detail.value());
    google::rpc::ErrorInfo info;
    if (detail.UnpackTo(&info)) {
      entry["debug"] = nlohmann::json::parse(Json::from_message(info), nullptr, false);
    }
    error["details"].push_back(std::move(entry));
  }
  return error.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace haptic::server
