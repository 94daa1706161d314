#!/bin/sh
# The positive control of include_direction.sh: a clean tree passes, each kind of breach is caught.
#
#   include_direction_test.sh SCRATCH-FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
check=$here/include_direction.sh
. "$here/../support/scratch.sh"
scratch=${1:?a scratch folder}
failures=0

fresh_tree() {
  fresh_folder "$scratch"
  mkdir -p "$scratch/core/src/tick" "$scratch/hw/board" "$scratch/server/front/grpc" \
    "$scratch/server/owner/loop" "$scratch/client/src" \
    "$scratch/client/include/haptic/client" "$scratch/client/hapticctl" "$scratch/proto/wire"
  cd "$scratch"
  printf '#include <array>\n#include <Eigen/Core>\n#include "haptic/core/types.hpp"\n' \
    >core/src/a.cpp
  printf '#include "tick/stages.hpp"\n// #include <thread> is a comment\n' >core/src/b.cpp
  printf '#include "haptic/core/time.hpp"\n#include <sys/stat.h>\n' >hw/board/a.cpp
  printf '#include "haptic/v1/session.pb.h"\n#include <grpcpp/grpcpp.h>\n' >server/front/grpc/a.cpp
  printf '#include <thread>\n#include "hw/device.hpp"\n' >server/owner/loop/a.cpp
  printf '#include "haptic/v1/haptic_service.grpc.pb.h"\n' >client/src/a.cpp
  printf '#include <chrono>\n' >client/include/haptic/client/client.hpp
  printf '#include "haptic/client/client.hpp"\n' >client/hapticctl/main.cpp
  printf '#include <openssl/evp.h>\n' >proto/wire/a.cpp
}

expect() {  # expect STATUS WHAT
  status=0
  sh "$check" "$scratch" >"$scratch.log" 2>&1 || status=$?
  if [ "$status" -ne "$1" ]; then
    echo "FAILED: $2: expected status $1, got $status"
    cat "$scratch.log"
    failures=1
  fi
}

breach() {  # breach FILE LINE
  fresh_tree
  printf '%s\n' "$2" >>"$1"
  expect 1 "$1 with $2"
}

fresh_tree
expect 0 "a clean tree"

breach core/src/a.cpp '#include <thread>'
breach core/src/a.cpp '#include <iostream>'
breach core/src/a.cpp '  #  include <mutex>'
breach core/src/a.cpp '#include "hw/device.hpp"'
breach core/src/a.cpp '#include <hw/device.hpp>'
breach core/src/a.cpp '#include "haptic/v1/session.pb.h"'
breach core/src/a.cpp '#include <grpcpp/grpcpp.h>'
breach core/src/a.cpp '#include "server/owner/loop/loop.hpp"'
breach core/src/a.cpp 'auto t = std::chrono::steady_clock::now();'
breach hw/board/a.cpp '#include <asio.hpp>'
breach hw/board/a.cpp '#include "haptic/v1/session.pb.h"'
breach hw/board/a.cpp '#include "server/owner/scene/scene.hpp"'
breach proto/wire/a.cpp '#include <asio/ip/udp.hpp>'
breach proto/wire/a.cpp '#include <grpcpp/grpcpp.h>'
breach proto/wire/a.cpp '#include "haptic/core/types.hpp"'
breach proto/wire/a.cpp 'auto t = std::chrono::steady_clock::now();'
breach client/src/a.cpp '#include "haptic/core/types.hpp"'
breach client/src/a.cpp '#include <Eigen/Core>'
breach client/src/a.cpp '#include "hw/device.hpp"'
breach client/src/a.cpp '#include "server/owner/app.hpp"'
breach client/src/a.cpp '#include <mujoco/mujoco.h>'
breach client/hapticctl/main.cpp '#include "haptic/mujoco/tool.hpp"'
breach client/include/haptic/client/client.hpp '#include <grpcpp/grpcpp.h>'
breach client/include/haptic/client/client.hpp '#include "haptic/v1/session.pb.h"'
breach client/hapticctl/main.cpp '#include <grpcpp/grpcpp.h>'
breach server/owner/loop/a.cpp '#include "haptic/v1/scene.pb.h"'
breach server/owner/loop/a.cpp '#include <grpcpp/server.h>'
breach server/owner/loop/a.cpp '#include <google/protobuf/text_format.h>'
breach server/owner/loop/a.cpp '#include "server/front/udp/udp_port.hpp"'
breach server/owner/loop/a.cpp '#include "haptic/wire/aead.hpp"'
breach server/front/grpc/a.cpp '#include "server/owner/rights/lease.hpp"'
breach server/front/grpc/a.cpp '#include "server/owner/scene/scene.hpp"'
breach server/front/grpc/a.cpp '#include "hw/device.hpp"'
breach server/front/grpc/a.cpp '#include "haptic/core/tick/pipeline.hpp"'
breach server/front/grpc/a.cpp '#include "haptic/client/client.hpp"'

fresh_folder "$scratch"
expect 2 "an empty tree"
exit $failures
