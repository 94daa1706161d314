# The container engine of docker/test.sh (sourced): which one, what it needs on this host, how it is called.
# Sets `engine`; `compose` and the functions here call it. `scratch` is a folder of the caller's.

# Docker where its daemon answers, else podman.
choose_engine() { # choose_engine [NAME]
  local candidate why=()
  for candidate in ${1:-docker podman}; do
    if ! command -v "$candidate" >/dev/null; then
      why+=("$candidate is not installed")
      continue
    fi
    if [[ $candidate == podman ]]; then configure_podman; fi
    if "$candidate" info >"$scratch/info" 2>&1; then
      engine=$candidate
      return 0
    fi
    why+=("$candidate: $(tail -n 1 "$scratch/info")")
  done
  printf 'no container engine works here:\n' >&2
  printf '  %s\n' "${why[@]}" >&2
  return 1
}

# A host whose cgroups are not version 2, or without systemd, needs words of its own (WIRE 7); elsewhere
# podman's configuration stands.
configure_podman() {
  [[ -z ${CONTAINERS_CONF:-} ]] || return 0
  if [[ -f /sys/fs/cgroup/cgroup.controllers && -d /run/systemd/system ]]; then return 0; fi
  cat >"$scratch/containers.conf" <<'CONF'
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
[containers]
default_ulimits = ["nofile=20000:20000", "nproc=4096:4096"]
CONF
  export CONTAINERS_CONF=$scratch/containers.conf
}

# Debian, from the registry where there is one, else made here.
base_image() {
  local image=docker.io/library/debian:bookworm-slim
  if "$engine" image inspect "$image" >/dev/null 2>&1 ||
    timeout 60 "$engine" pull --quiet "$image" >/dev/null 2>&1; then
    echo "$image"
    return 0
  fi
  sh "$root/docker/base-image.sh" "$engine" || return 1
  echo localhost/debian:bookworm
}

compose() {
  if [[ $engine == docker ]]; then
    docker compose -p "$project" -f "$root/docker/compose.yaml" "$@"
  else
    podman-compose -p "$project" -f "$root/docker/compose.yaml" "$@"
  fi
}

# container SERVICE: the id of the newest container of a service of this run.
container() {
  "$engine" ps --all --latest --quiet --filter "label=com.docker.compose.project=$project" \
    --filter "label=com.docker.compose.service=$1"
}

# Everything this run made, by its label; the images unless they are to be kept.
tear_down() {
  local ids
  ids=$("$engine" ps --all --quiet --filter "label=com.docker.compose.project=$project")
  # A paused container cannot be stopped.
  # shellcheck disable=SC2086
  if [[ -n $ids ]]; then
    "$engine" unpause $ids >/dev/null 2>&1 || true
    "$engine" rm --force --volumes $ids >/dev/null
  fi
  ids=$("$engine" network ls --quiet --filter "name=^${project}_")
  # shellcheck disable=SC2086
  if [[ -n $ids ]]; then "$engine" network rm $ids >/dev/null; fi
}

left_behind() {
  "$engine" ps --all --quiet --filter "label=com.docker.compose.project=$project"
  "$engine" network ls --quiet --filter "name=^${project}_"
  "$engine" volume ls --quiet --filter "label=com.docker.compose.project=$project"
}
