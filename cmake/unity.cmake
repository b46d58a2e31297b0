# Groups of source files that are compiled as one (CMake's unity build), so that the headers of the standard library and of
# nlohmann-json, which cost most of such a file's time, are read once for all of them. The files of a group share their unnamed
# namespace: a name that two of them define is an error. AUTO leaves the groups out where a compiler cache works, since it
# knows single files better.
set(UNLATCH_UNITY AUTO CACHE STRING "Groups of source files compiled as one: ON, OFF, or AUTO: unless a compiler launcher such as ccache is set")
set(unlatch_unity ${UNLATCH_UNITY})
if(UNLATCH_UNITY STREQUAL "AUTO")
  set(unlatch_unity ON)
  if(CMAKE_CXX_COMPILER_LAUNCHER)
    set(unlatch_unity OFF)
  endif()
endif()

# unlatch_unite(TARGET GROUP FILE...): these files of the target are compiled as one.
function(unlatch_unite target group)
  if(unlatch_unity)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${group})
  endif()
endfunction()

# unlatch_unite_folders(TARGET MOST FOLDER...): the target's files in each of these folders, MOST of them as one.
function(unlatch_unite_folders target most)
  get_target_property(files ${target} SOURCES)
  foreach(folder IN LISTS ARGN)
    set(count 0)
    foreach(file IN LISTS files)
      cmake_path(GET file PARENT_PATH parent)
      if(parent STREQUAL folder)
        math(EXPR number "${count} / ${most}")
        string(MAKE_C_IDENTIFIER "${folder}_${number}" group)
        unlatch_unite(${target} ${group} ${file})
        math(EXPR count "${count} + 1")
      endif()
    endforeach()
  endforeach()
endfunction()

# unlatch_unite_all(TARGET [EXCEPT FILE...]): all files of the target, but these, are compiled as one.
function(unlatch_unite_all target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "EXCEPT")
  get_target_property(files ${target} SOURCES)
  list(FILTER files INCLUDE REGEX "\\.cc$")
  list(REMOVE_ITEM files "" ${arg_EXCEPT})
  unlatch_unite(${target} all ${files})
endfunction()

# unlatch_unite_below(TARGET GROUP FOLDER...): the target's files in these folders and below them are compiled as one.
function(unlatch_unite_below target group)
  get_target_property(files ${target} SOURCES)
  list(JOIN ARGN "|" folders)
  list(FILTER files INCLUDE REGEX "^(${folders})/[^$]*\\.cc$")
  unlatch_unite(${target} ${group} ${files})
endfunction()

# unlatch_unite_in(TARGET MOST): all files of the target, MOST of them as one.
function(unlatch_unite_in target most)
  get_target_property(files ${target} SOURCES)
  list(FILTER files INCLUDE REGEX "\\.cc$")
  set(count 0)
  foreach(file IN LISTS files)
    math(EXPR number "${count} / ${most}")
    unlatch_unite(${target} files_${number} ${file})
    math(EXPR count "${count} + 1")
  endforeach()
endfunction()
