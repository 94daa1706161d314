# Part of `cmake --install`: writes the files that hold absolute paths of the installation. Given:
# `template` of the unit, the `scene` a fresh installation serves, `bindir` below the prefix.
set(prefix "${CMAKE_INSTALL_PREFIX}")
set(root "$ENV{DESTDIR}")
if(prefix STREQUAL "/usr")  # the distribution's own: its settings are in /etc (FHS)
  set(settings /etc/hapticd)
else()
  set(settings "${prefix}/etc/hapticd")
endif()
set(HAPTICD "${prefix}/${bindir}/hapticd")
set(SCENE "${settings}/scene.textproto")
configure_file("${template}" "${root}${prefix}/lib/systemd/system/hapticd.service" @ONLY)
# What its owner has changed stays.
if(NOT EXISTS "${root}${SCENE}")
  configure_file("${scene}" "${root}${SCENE}" COPYONLY)
endif()
message(STATUS "Wrote: ${root}${prefix}/lib/systemd/system/hapticd.service, ${root}${SCENE}")
