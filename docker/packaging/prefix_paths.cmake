# Part of `cmake --install`: writes the files that hold absolute paths of the installation. Given:
# `template` of the unit, the `scene` that a new installation serves, the `limits` of the group,
# `bindir` below the prefix.
set(prefix "${CMAKE_INSTALL_PREFIX}")
set(root "$ENV{DESTDIR}")
if(prefix STREQUAL "/usr")  # the distribution's own: its settings are in /etc (FHS)
  set(etc /etc)
else()
  set(etc "${prefix}/etc")
endif()
set(HAPTICD "${prefix}/${bindir}/hapticd")
set(SCENE "${etc}/hapticd/scene.textproto")
configure_file("${template}" "${root}${prefix}/lib/systemd/system/hapticd.service" @ONLY)
# A file that its owner has changed stays.
if(NOT EXISTS "${root}${SCENE}")
  configure_file("${scene}" "${root}${SCENE}" COPYONLY)
endif()
configure_file("${limits}" "${root}${etc}/security/limits.d/haptic.conf" COPYONLY)
message(STATUS "Wrote: ${root}${prefix}/lib/systemd/system/hapticd.service, ${root}${SCENE}")
