"""Where a hapticd on this host listens by default, as in
proto/wire/include/haptic/wire/ports.hpp."""

DEFAULT_SERVER = "127.0.0.1:29470"
