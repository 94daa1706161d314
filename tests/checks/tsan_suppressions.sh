#!/bin/sh
# tests/tsan.supp may excuse only Debian's builds of gRPC, Abseil and protobuf, which are not
# instrumented and cause hundreds of reports. One function of libgrpc++ is inlined from its header,
# so it has no library's name.
#
#   tsan_suppressions.sh [FILE]
set -u
file=${1:-$(dirname "$0")/../tsan.supp}
[ $# -eq 0 ] || shift
more=${*:+$(printf '|%s' "$@")}
rules=$(grep -vE '^[[:space:]]*(#|$)' "$file") ||
  { echo "$file: missing or without rules"; exit 2; }
others=$(echo "$rules" |
  grep -vxF 'race:grpc::internal::CallOpClientRecvStatus::FinishOp' |
  grep -vE '^(race|called_from_lib|mutex|deadlock|thread|signal|race_top):(libgrpc(\+\+)?|libabsl(_[a-z_]+)?|libprotobuf|libgpr|libupb'"$more"')[.*so0-9]*$')
if [ -n "$others" ]; then
  echo "$file: only libgrpc, libabsl, libprotobuf${*:+ and $*} may be named; found:"
  echo "$others"
  exit 1
fi
