# find_package(unlatch) defines what is installed: unlatch::kernel, the C++ kernel, which needs nothing but Eigen; unlatch::library,
# the C library. find_package(unlatch COMPONENTS library) asks for that one alone.
include(CMakeFindDependencyMacro)
if(EXISTS ${CMAKE_CURRENT_LIST_DIR}/unlatch-targets.cmake AND (NOT unlatch_FIND_COMPONENTS OR kernel IN_LIST unlatch_FIND_COMPONENTS))
  find_dependency(Eigen3 3.4 NO_MODULE)
  include(${CMAKE_CURRENT_LIST_DIR}/unlatch-targets.cmake)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/unlatch-library-targets.cmake OPTIONAL)
foreach(component IN LISTS unlatch_FIND_COMPONENTS)
  if(NOT TARGET unlatch::${component} AND unlatch_FIND_REQUIRED_${component})
    set(unlatch_FOUND FALSE)
    set(unlatch_NOT_FOUND_MESSAGE "the component '${component}' of unlatch is not installed (known: kernel, library)")
  endif()
endforeach()
