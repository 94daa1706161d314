# The image and the composition (sourced by docker/test.sh).

readonly LARGEST_MB=150

# True if the programs of a build folder are from this tree and run in the image; prints why if not.
# Builds them first, so that the tests see the sources as they are.
usable() { # usable BUILD
  local cache=$1/CMakeCache.txt here there
  [[ -f $cache ]] || { echo "$1 is no build folder"; return 1; }
  grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache" ||
    { echo "$1 is a build of another tree"; return 1; }
  grep -qxF 'HAPTIC_SANITIZE:STRING=' "$cache" || { echo "$1 is a sanitizer's"; return 1; }
  here=$(distribution </etc/os-release)
  there=$("$engine" run --rm --label "com.docker.compose.project=$project" "$base" \
    cat /etc/os-release | distribution)
  [[ $here == "$there" ]] || { echo "this host is $here, the image $there"; return 1; }
  cmake --build "$1" --target hapticd hapticctl haptic-example-virtual-wall \
    haptic-example-soft-grasp haptic-relay haptic-board-emulator \
    haptic_python >"$logs/prebuilt.log" 2>&1 ||
    { echo "$1 does not build, see $logs/prebuilt.log"; return 1; }
}
distribution() { # of an os-release on standard input
  (. /dev/stdin && echo "${ID:-unknown} ${VERSION_ID:-}")
}

stage_prebuilt() { # installs from the build folder into the build context
  local component
  rm -rf "$root/build/container"
  for component in server client relay; do
    DESTDIR=$root/build/container cmake --install "$prebuilt" --prefix /usr --strip \
      --component "$component" >/dev/null
  done
}

# built TAG ARGUMENT...: builds the Dockerfile. Always in the same format, so that the second build
# uses the cache of the first.
built() {
  local tag=$1 format=()
  shift
  if [[ $engine == podman ]]; then format=(--format docker); fi # for the HEALTHCHECK
  "$engine" build "${format[@]}" --build-arg "BASE=$base" "$@" --tag "$tag" \
    --file "$root/docker/Dockerfile" "$root" >>"$logs/build.log" 2>&1
}

build_image() {
  local arguments=() why
  if [[ -n $prebuilt ]] && ! why=$(usable "$prebuilt"); then
    step "not taken from a build: $why"
    prebuilt=
  fi
  if [[ -n $prebuilt ]]; then
    step "programs and packages: those of $prebuilt"
    stage_prebuilt
    arguments=(--build-arg PREBUILT=build/container)
  else
    step "programs and packages: compiled in the image"
  fi
  : >"$logs/build.log" # remove_layers must not find the layers of an earlier run in it
  built "$image" "${arguments[@]}" || {
    tail -n 30 "$logs/build.log" >&2
    fail "the image does not build"
  }
  local size
  size=$(("$("$engine" image inspect --format '{{.Size}}' "$image")" / 1000000))
  step "image: $size MB on $base"
  ((size <= LARGEST_MB)) || fail "the image has $size MB: at most $LARGEST_MB"
  [[ $("$engine" image inspect --format '{{.Config.User}}' "$image") == 990:990 ]] ||
    fail "the image runs as root"
  "$engine" image inspect "$image" >"$scratch/inspected"
  grep -q '"hapticctl"' "$scratch/inspected" || fail "the image has no HEALTHCHECK"
  local label
  for label in title description licenses; do
    grep -q "\"org.opencontainers.image.$label\": \"..*\"" "$scratch/inspected" ||
      fail "the image has no label $label"
  done
}

# The hand presses steadily and never lets go, so that trouble always meets force. Without force the
# finger is far from its proxy, so the engage window is wide.
start_composition() {
  export HAPTICD_IMAGE=$image HAPTICD_BASE=$base HAPTICD_SCENE=finger_constant
  export HAPTICD_SETTING=device[0].limits.engage_window_n=25
  compose up --detach --no-build hand board >"$logs/compose.log" 2>&1 || {
    tail -n 20 "$logs/compose.log" >&2
    fail "the composition does not start"
  }
  local service
  for service in hand board; do
    eventually 120 healthy "$(container "$service")" ||
      fail "$service is not healthy"
  done
  if [[ $engine == podman ]]; then "$engine" healthcheck run "$(container hand)" >/dev/null; fi
  "$engine" exec "$(container hand)" sh -c '[ "$(id -u)" = 990 ]' || fail "root in the container"
  # From /proc/mounts: a write would fail for this user even if the root were writable.
  "$engine" exec "$(container hand)" cat /proc/mounts >"$scratch/mounts"
  grep -qE '^[^ ]+ / [^ ]+ ro(,| )' "$scratch/mounts" ||
    fail "the root is writable: $(grep ' / ' "$scratch/mounts")"
  "$engine" exec "$(container board)" hapticctl info >"$scratch/board"
  grep -q '(board)' "$scratch/board" || fail "the second server has no board"
  says_its_grade
  compose up --detach --no-build observer simulation >>"$logs/compose.log" 2>&1
  pressing "the first grasp"
  step "composition: two servers healthy, non-root, read-only; force by the simulation"
}

# A loaded machine may have latched a fault: clears it, so that the next call can succeed.
healthy() { # healthy CONTAINER
  "$engine" exec "$1" hapticctl health && return 0
  "$engine" exec "$1" hapticctl clear-fault
  return 1
}

# The server's first line has its grade; without SCHED_FIFO that is 'degraded'.
says_its_grade() {
  local grade
  "$engine" logs "$(container hand)" >"$scratch/words" 2>&1
  grade=$(grep -m 1 -o "real-time grade '[a-z-]*'.*" "$scratch/words")
  step "$grade"
  case "$grade" in
    "real-time grade 'real-time'"*) ;;
    "real-time grade 'degraded': SCHED_FIFO refused"*) ;;
    *) fail "the server does not say what it was not granted" ;;
  esac
}

# Removes the layers that podman keeps of this build, by the ids in its log, last first, and the
# containers of an interrupted build. Those of other builds stay.
remove_layers() {
  local id layers
  if [[ $engine != podman || ! -f $logs/build.log ]]; then return 0; fi
  layers=$(grep -oE '^--> [0-9a-f]{11,}' "$logs/build.log" | cut -c 5-15 | tac |
    grep -vxF -e none \
      -f <(grep -oE 'Using cache [0-9a-f]{11}' "$logs/build.log" | cut -c 13-) || true)
  for id in $layers; do
    podman ps --all --external --format '{{.ID}} {{.ImageID}}' | grep -F " $id" | cut -d ' ' -f 1 |
      xargs --no-run-if-empty podman rm --force >/dev/null 2>&1 || true
    podman rmi "$id" >/dev/null 2>&1 || true
  done
}
