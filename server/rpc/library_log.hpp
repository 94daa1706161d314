#pragma once
/// What gRPC and protobuf have to say goes where the rest of the log goes: by themselves they would
/// write to standard error, and wait for whoever reads it (private to server/rpc).

namespace haptic::server {

/// For the whole process. Idempotent.
void take_library_logs();

}  // namespace haptic::server
