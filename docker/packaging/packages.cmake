# cpack -G DEB: hapticd, hapticd-client, python3-haptic, libhaptic-dev, libhaptic0, libhaptic-c-dev,
# and libhaptic-mujoco-dev if MuJoCo is here. The prefix is always /usr.
# lintian finds no error. Three warnings stay: initial-upload-closes-no-bugs (no upload to Debian),
# pkg-config-unavailable-for-cross-compilation (the packages are for the machine that builds them),
# and maintscript-calls-ldconfig (cpack writes that call, next to the trigger that suffices).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME hapticd)
set(CPACK_PACKAGE_CONTACT "The hapticd authors <hapticd@users.noreply.github.com>")
set(CPACK_PACKAGE_VENDOR "hapticd")
set(CPACK_COMPONENTS_ALL server client python dev c c_dev)
if(TARGET haptic_mujoco)
  list(APPEND CPACK_COMPONENTS_ALL mujoco)
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own first line
set(CPACK_SET_DESTDIR ON)  # the unit and its scene are absolute paths
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)  # as in debian/changelog
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)  # of libhaptic0 alone: no other has a library
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SERVER_PACKAGE_NAME hapticd)
set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME hapticd-client)
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS avahi-daemon)  # the example of docker/packaging/avahi
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS avahi-utils)   # hapticctl find
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-haptic)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3-cffi-backend, \
libhaptic0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python client of hapticd
Sessions that reconnect, states, force, events and contacts: a binding over
the C library libhaptic0.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libhaptic-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libgrpc++-dev, libprotobuf-dev, libssl-dev")
set(CPACK_DEBIAN_C_PACKAGE_NAME libhaptic0)  # by its SONAME
set(CPACK_DEBIAN_C_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_C_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/debian/triggers)
set(CPACK_DEBIAN_C_DESCRIPTION "client of hapticd for C, shared library
What simulations in C, and in languages that call C, talk to hapticd with.")
set(CPACK_DEBIAN_C_DEV_PACKAGE_NAME libhaptic-c-dev)
set(CPACK_DEBIAN_C_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_C_DEV_PACKAGE_DEPENDS
    "libhaptic0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_DEBIAN_C_DEV_DESCRIPTION "development files of hapticd's client for C
Header, link for the linker, and what CMake and pkg-config need.")
set(CPACK_DEBIAN_MUJOCO_PACKAGE_NAME libhaptic-mujoco-dev)
set(CPACK_DEBIAN_MUJOCO_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_MUJOCO_PACKAGE_DEPENDS "libhaptic-dev, libmujoco-dev")
set(CPACK_DEBIAN_MUJOCO_DESCRIPTION "haptic::mujoco, which makes MuJoCo simulations haptic
Headers, static library and models: joints or bodies follow a haptic device,
and their contacts are told to hapticd.")
set(CPACK_DEBIAN_SERVER_DESCRIPTION "networked haptic server for underactuated devices
A daemon that owns a haptic device and its 1 kHz loop. Simulations stream
where their virtual object lets the finger be; the daemon renders the force
and ends it when they fall silent.")
set(CPACK_DEBIAN_CLIENT_DESCRIPTION "command-line client and examples of hapticd
hapticctl shows a server and its devices, asks for force, stops it, and
clears faults.")
set(CPACK_DEBIAN_DEV_DESCRIPTION "development files of hapticd's clients
Headers, static libraries and protocol buffers of haptic::client,
haptic::proto and haptic::wire.")
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
    ${CMAKE_CURRENT_SOURCE_DIR}/debian/conffiles ${CMAKE_CURRENT_SOURCE_DIR}/debian/postinst
    ${CMAKE_CURRENT_SOURCE_DIR}/debian/prerm)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
include(CPack)
