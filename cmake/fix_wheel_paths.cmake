# SPDX-License-Identifier: Apache-2.0
# The CMake targets that the ROS wheels export carry include paths of the machine that built the
# wheels (/opt/python/...), and CMake refuses a target with a path that does not exist. Once all
# targets are known, drop those paths. Passed as CMAKE_PROJECT_INCLUDE, so it runs in `project()`.

function(psane_drop_missing_include_paths)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(paths ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT paths)
      continue()
    endif()
    set(kept)
    foreach(path IN LISTS paths)
      # A generator expression is no path yet, and is kept as it is.
      if(path MATCHES "\\$<" OR EXISTS "${path}")
        list(APPEND kept "${path}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept}")
  endforeach()
endfunction()

cmake_language(DEFER CALL psane_drop_missing_include_paths)
