// Browsers and other clients that speak HTTP, in a scene.
#include <set>

#include "haptic/wire/ports.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

/// In the order of the words of `rights`.
constexpr WebRights kRights[] = {{false, Priority::kTest},
                                 {true, Priority::kTest},
                                 {true, Priority::kPrimary},
                                 {true, Priority::kOperator}};

}  // namespace

WebConfig read_web(const Part<v1::WebScene>& part, std::set<std::string>& addresses) {
  WebConfig web;
  if (part->listen().empty()) part->add_listen(wire::kDefaultWeb);
  web.listen = read_addresses(part, part->listen(), addresses);
  for (int i = 0; i < part->name_size(); ++i) {
    const std::string& name = web.names.emplace_back(part->name(i));
    if (matches(name, R"((\[[0-9a-f:.]{2,45}\]|[a-z0-9.-]{1,253}))")) continue;
    part.wrong({"name", static_cast<std::size_t>(i)}, quoted(name),
               "must be a name of [a-z0-9.-] or an address, without a port");
  }
  for (int i = 0; i < part->origin_size(); ++i) {
    const std::string& origin = web.origins.emplace_back(part->origin(i));
    if (matches(origin, R"(https?://(\[[0-9a-f:.]+\]|[a-z0-9.-]+)(:[0-9]{1,5})?)")) continue;
    part.wrong({"origin", static_cast<std::size_t>(i)}, quoted(origin),
               R"(must be "https://name" or "http://name:port", in lower case)");
  }
  std::set<std::string> names;
  for (const auto& token : part.parts<v1::WebTokenScene>("token")) {
    if (token->name().empty()) token.missing("name", "of who shows the token");
    if (!names.insert(token->name()).second) {
      token.wrong("name", quoted(token->name()), "must be another: this one is listed already");
    }
    if (token->file().empty()) token.missing("file", "the name of a file that holds the token");
    const std::size_t rights = token.word("rights", {"observe", "test", "primary", "operator"});
    web.tokens.push_back(
        {token->name(), token.file("file", "a file that holds a token"), kRights[rights]});
  }
  if (part.word("printed", {"observe", "control"}, "observe") == 1) {
    web.printed = {true, Priority::kPrimary};
  }
  return web;
}

}  // namespace haptic::server
