#pragma once
/// Sends the messages of gRPC and protobuf to the server's log. By themselves they would write to
/// standard error and wait for its reader (private to server/rpc).

namespace haptic::server {

/// For the whole process. Idempotent.
void take_library_logs();

}  // namespace haptic::server
