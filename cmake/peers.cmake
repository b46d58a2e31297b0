# Other multibody programs beside which unlatch is tested and timed, where they are installed (tools/setup test):
# targets unlatch_peer_mujoco and unlatch_peer_simbody, compiled once for tests and benches.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)

# Debian's mujocoConfig.cmake names include directories that it does not install.
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
find_library(MUJOCO_LIBRARY mujoco)
if(MUJOCO_INCLUDE_DIR AND MUJOCO_LIBRARY)
  add_library(unlatch_peer_mujoco STATIC ${PROJECT_SOURCE_DIR}/tests/support/peers/mujoco_system.cc)
  target_include_directories(unlatch_peer_mujoco SYSTEM PRIVATE ${MUJOCO_INCLUDE_DIR})
  target_link_libraries(unlatch_peer_mujoco PUBLIC unlatch_test_support PRIVATE unlatch_options ${MUJOCO_LIBRARY})
endif()

find_package(Simbody CONFIG QUIET)
if(Simbody_FOUND)
  # Its headers are ambiguous in C++20, and Debian builds the library without NDEBUG, on which its classes' layout depends.
  add_library(unlatch_peer_simbody STATIC ${PROJECT_SOURCE_DIR}/tests/support/peers/simbody_system.cc
    ${PROJECT_SOURCE_DIR}/tests/support/peers/simbody_blow.cc)
  set_target_properties(unlatch_peer_simbody PROPERTIES CXX_STANDARD 17)
  target_include_directories(unlatch_peer_simbody SYSTEM PRIVATE ${Simbody_INCLUDE_DIR})
  target_compile_options(unlatch_peer_simbody PRIVATE -UNDEBUG)
  target_link_libraries(unlatch_peer_simbody PUBLIC unlatch_test_support PRIVATE unlatch_options ${Simbody_LIBRARIES})
endif()
