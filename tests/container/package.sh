# The .deb packages in a clean container (sourced by docker/test.sh).

test_packages() {
  local debs=$scratch/debs began=$SECONDS
  mkdir -p "$debs"
  if [[ -n $prebuilt ]]; then
    cpack -G DEB --config "$prebuilt/CPackConfig.cmake" -B "$debs" >"$logs/cpack.log" 2>&1 ||
      fail "cpack; see $logs/cpack.log"
  else
    packages_of_image "$debs"
  fi
  rm -rf "$debs/_CPack_Packages" "$debs"/libhaptic*-dev_*
  chmod -R a+rX "$scratch"
  "$engine" run --rm --name "${project}_clean" --label "com.docker.compose.project=$project" \
    --volume "$debs:/debs:ro" --volume "$root/tests/container/use_packages.sh:/use_packages.sh:ro" \
      "$base" \
    sh /use_packages.sh >"$logs/packages.log" 2>&1 || {
    tail -n 20 "$logs/packages.log" >&2
    fail "the packages do not work in a clean container"
  }
  step "packages: $(tail -n 1 "$logs/packages.log"), in $((SECONDS - began)) s"
}

# Builds the build stage again, from the cache, and copies the packages from it.
packages_of_image() {
  local tag=$image-packages id
  built "$tag" --target build || fail "the build stage"
  # The container is never started, but an engine wants a command, and this stage names none.
  id=$("$engine" create --label "com.docker.compose.project=$project" "$tag" true)
  "$engine" cp "$id:/packages/." "$1" >/dev/null
  "$engine" rm "$id" >/dev/null
  "$engine" rmi --force "$tag" >/dev/null
}
