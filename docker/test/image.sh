# The image and the composition (sourced by docker/test.sh).

readonly LARGEST_MB=150

stage_prebuilt() { # the installation of a build folder, inside the build context
  local component
  rm -rf "$root/build/container"
  for component in server client relay; do
    DESTDIR=$root/build/container cmake --install "$prebuilt" --prefix /usr --strip \
      --component "$component" >/dev/null
  done
}

build_image() {
  local format=() arguments=()
  base=$(base_image) || fail "no base image"
  if [[ $engine == podman ]]; then format=(--format docker); fi # for the HEALTHCHECK
  if [[ -n $prebuilt ]]; then
    stage_prebuilt
    arguments=(--build-arg PREBUILT=build/container)
  fi
  "$engine" build "${format[@]}" --build-arg "BASE=$base" "${arguments[@]}" --tag "$image" \
    --file "$root/docker/Dockerfile" "$root" >"$logs/build.log" 2>&1 || {
    tail -n 30 "$logs/build.log" >&2
    fail "the image does not build"
  }
  local size
  size=$(("$("$engine" image inspect --format '{{.Size}}' "$image")" / 1000000))
  step "image: $size MB on $base"
  ((size <= LARGEST_MB)) || fail "the image has $size MB: at most $LARGEST_MB"
  [[ $("$engine" image inspect --format '{{.Config.User}}' "$image") == 990:990 ]] ||
    fail "the image runs as root"
  "$engine" image inspect "$image" | grep -q '"hapticctl"' || fail "the image has no HEALTHCHECK"
}

# The hand presses steadily, so that there is force to lose whenever trouble comes; it never lets go either, so
# force may begin wherever the finger has got to without it.
start_composition() {
  export HAPTICD_IMAGE=$image HAPTICD_BASE=$base HAPTICD_SCENE=finger_constant
  export HAPTICD_SETTING=device[0].limits.engage_window_n=25
  compose up --detach --no-build hand board >"$logs/compose.log" 2>&1 || {
    tail -n 20 "$logs/compose.log" >&2
    fail "the composition does not start"
  }
  local service
  for service in hand board; do
    eventually 60 healthy "$(container "$service")" ||
      fail "$service is not healthy"
  done
  if [[ $engine == podman ]]; then "$engine" healthcheck run "$(container hand)" >/dev/null; fi
  "$engine" exec "$(container hand)" sh -c '[ "$(id -u)" = 990 ]' || fail "root in the container"
  if "$engine" exec "$(container hand)" sh -c 'echo x >/usr/x' 2>/dev/null; then fail "the root is writable"; fi
  "$engine" exec "$(container board)" hapticctl info >"$scratch/board"
  grep -q '(board)' "$scratch/board" || fail "the second server has no board"
  says_its_grade
  compose up --detach --no-build observer simulation >>"$logs/compose.log" 2>&1
  pressing "the first grasp"
  step "composition: two servers healthy, non-root, read-only; force by the simulation"
}

# A loaded machine may have latched a fault: cleared, and looked at again.
healthy() { # healthy CONTAINER
  "$engine" exec "$1" hapticctl health && return 0
  "$engine" exec "$1" hapticctl clear-fault
  return 1
}

# Without SCHED_FIFO the server runs degraded, and its first words are so.
says_its_grade() {
  local grade
  grade=$("$engine" logs "$(container hand)" 2>&1 | grep -m 1 -o "real-time grade '[a-z-]*'.*")
  step "$grade"
  case "$grade" in
    "real-time grade 'real-time'"*) ;;
    "real-time grade 'degraded': SCHED_FIFO refused"*) ;;
    *) fail "the server does not say what it was not granted" ;;
  esac
}
