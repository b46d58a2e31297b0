# cmake --install: the kernel as a library that find_package(unlatch) finds, in component `kernel`; and, in a full build,
# the C library, in component `library` (library/CMakeLists.txt), and the executables, in component `tools`. Headers keep their spelling: #include "unlatch/model.h".
include(CMakePackageConfigHelpers)

set_target_properties(unlatch_kernel PROPERTIES EXPORT_NAME kernel)
install(TARGETS unlatch_kernel EXPORT unlatch COMPONENT kernel
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY kernel/include/unlatch DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT kernel)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/unlatch)
install(EXPORT unlatch NAMESPACE unlatch:: FILE unlatch-targets.cmake DESTINATION ${package_dir} COMPONENT kernel)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/unlatch-config-version.cmake COMPATIBILITY SameMinorVersion)
foreach(component kernel library)
  install(FILES cmake/unlatch-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/unlatch-config-version.cmake
    DESTINATION ${package_dir} COMPONENT ${component})
endforeach()

if(NOT UNLATCH_KERNEL_ONLY)
  install(TARGETS unlatch unlatch-fsw COMPONENT tools RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  set(share ${CMAKE_BINARY_DIR}/tools/share)
  install(DIRECTORY ${share}/man/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT tools)
  install(FILES ${share}/completion/unlatch DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT tools)
  install(FILES ${share}/completion/_unlatch DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT tools)
  install(FILES ${share}/completion/unlatch.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT tools)
  install(DIRECTORY hil/scenarios DESTINATION ${CMAKE_INSTALL_DATADIR}/unlatch COMPONENT tools)
  # What flight software copies: the participant, its wire, the stacks around it (bridge/stacks/README.md).
  install(DIRECTORY bridge/participant bridge/stacks DESTINATION ${CMAKE_INSTALL_DATADIR}/unlatch/bridge COMPONENT library)
  install(FILES bridge/schema/unlatch_wire.h bridge/schema/unlatch_frame.h bridge/schema/unlatch.idl
    DESTINATION ${CMAKE_INSTALL_DATADIR}/unlatch/bridge/schema COMPONENT library)
endif()
