#!/bin/sh
# A program linked with all of haptic_owner contains nothing of the network: no gRPC, asio, HTTP or
# OpenSSL, neither as a library nor as code.
#
#   owner_links.sh PROGRAM
set -u
program=${1:?a program}
[ -x "$program" ] || exit 2
found=$(readelf -d "$program" | grep -E 'NEEDED.*lib(grpc|gpr|ssl|crypto|boost)'
  nm -C "$program" | grep -E '(^| )(grpc|asio|boost)::| (SSL|EVP)_')
[ -z "$found" ] && exit 0
echo "$program has what the owner of the devices must not know:"
echo "$found" | head -n 10
exit 1
