"""The ports of hapticd, as in proto/wire/include/haptic/wire/ports.hpp."""

GRPC_PORT = 29470
UDP_PORT = 29471
METRICS_PORT = 29472
DEFAULT_SERVER = f"127.0.0.1:{GRPC_PORT}"
