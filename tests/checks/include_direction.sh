#!/bin/sh
# The direction of dependency (CONTRIBUTING.md#rooms): Eigen <- core <- hw <- server -> proto, wire
# <- client.
#
#   include_direction.sh [ROOT]
#
# Reads every #include, <> and "" alike, below the rooms and prints each that points the wrong way.
# Exit status: 0 none, 1 some, 2 there was nothing to check.
set -u
root=${1:-$(dirname "$0")/../..}
cd "$root" || exit 2

# "file:line header" per include, with < or " kept as the header's first character.
includes() {
  [ -d "$1" ] || return 0
  find "$1" -type f \( -name '*.hpp' -o -name '*.cpp' -o -name '*.h' -o -name '*.c' \) \
    -exec grep -HnE '^[[:space:]]*#[[:space:]]*include' {} + |
    sed -nE 's/^([^:]+:[0-9]+):[^<"]*([<"][^>"]+)[>"].*/\1 \2/p'
}

breaches=0
report() {  # report RULE, with the offending lines on stdin
  found=$(cat)
  [ -z "$found" ] && return
  echo "$found" | sed "s|\$|     <- $1|; s| [<\"]| includes |"
  breaches=1
}
# forbid ROOM... -- PATTERN RULE: no header below ROOM matches PATTERN.
forbid() {
  rooms=
  while [ "$1" != -- ]; do rooms="$rooms $1"; shift; done
  report "$3" <<LINES
$(for room in $rooms; do includes "$room"; done | grep -E " [<\"]($2)")
LINES
}
# allow ROOM PATTERN RULE: every header below ROOM matches PATTERN.
allow() {
  report "$3" <<LINES
$(includes "$1" | grep -vE " ($2)")
LINES
}

[ -n "$(includes core)" ] || { echo "include_direction: no sources below $root/core" >&2; exit 2; }

grpc='grpc|grpcpp/|google/|absl/|haptic/v1/|upb/'
standard='<[a-z_]+$'
threads='(thread|mutex|shared_mutex|condition_variable|future|semaphore|latch|barrier|stop_token)$'
streams='(iostream|ostream|istream|fstream|sstream|syncstream|print)$'
own='"[a-z_]+(/[a-z_0-9]+)*\.hpp'
other_rooms='"(hw|server|client|proto|tests|haptic/(client|wire|v1))/'

allow core "$standard|<Eigen/|\"haptic/core/|$own" "core includes Eigen, std and itself"
forbid core -- "$threads|$streams" "core knows no thread, lock or stream"
report "core includes Eigen, std and itself" <<LINES
$(includes core | grep -E " $other_rooms")
LINES
forbid hw -- "$grpc|asio|boost/|server/|haptic/client/|haptic/wire/|proto/" \
  "hw knows core and the operating system"
forbid proto -- "haptic/core/|hw/|server/|haptic/client/|Eigen/|asio|grpc|grpcpp/" \
  "wire knows std and OpenSSL"
forbid client -- "haptic/core/|hw/|server/|Eigen/" "client knows neither core, hw nor server"
allow client/include "$standard|\"haptic/client/" "client's public headers show only std"
forbid client/c client/examples -- "$grpc" \
  "programs on the client library do without gRPC and protobuf"
forbid client/hapticctl -- "grpc|grpcpp/" "hapticctl prints messages, and calls nothing itself"
forbid client/c client/src client/include client/hapticctl client/examples -- \
  "mujoco/|haptic/mujoco/" "only client/mujoco knows MuJoCo"
forbid server -- "haptic/client/|tests/" "server knows no client"
owner="server/base server/crossing server/owner"
forbid $owner -- "grpc|asio|boost/|openssl/|server/front/" \
  "the owner of the devices knows no network"
report "the owner of the devices knows no network" <<LINES
$(for room in $owner; do includes "$room"; done | grep ' "haptic/wire/' |
  grep -vE '/(control_names|ports|printable|utf8)\.hpp$')
LINES
forbid server/front -- "server/owner/" "the front knows the owner by the crossing"
forbid server/base server/crossing server/front -- "hw/" "only the owner knows devices"
values='contacts/proxy_snapshot|error|fault|rendering/renderer_kind|safety/(lifecycle|staleness)'
values="$values|time|types"
report "the front knows of core its value types" <<LINES
$(for room in server/base server/crossing server/front; do includes "$room"; done |
  grep -E ' [<"]haptic/core/' | grep -vE "/core/($values)\.hpp$")
LINES
forbid server/base server/crossing -- "server/(front|owner)/" \
  "what both processes know needs neither"
report "proto types stop at server/{front,owner/{link,rights,scene,state,telemetry}}" <<LINES
$(includes server |
  grep -vE '^server/(front|owner/(link|rights|scene|state|telemetry))/' |
  grep -E " [<\"]($grpc)")
LINES

# Core reads no clock: not an include, but the same contract.
report "core and wire read no clock" <<LINES
$(find core $([ -d proto/wire ] && echo proto/wire) -name '*.[ch]pp' \
  -exec grep -HnE '(::now[[:space:]]*\(|clock_gettime|gettimeofday)' {} + |
  grep -vE ':[0-9]+:[[:space:]]*//' | sed -E 's/^([^:]+:[0-9]+):.*/\1 "a clock/')
LINES

exit $breaches
