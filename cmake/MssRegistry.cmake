# mss_registry(FILE MACRO name...) writes build/generated/<this folder>/FILE with one line MACRO(name) each, for a
# registry.cpp to include. Order is kept: lists and charts follow it.
function(mss_registry file macro)
  set(lines "")
  foreach(name IN LISTS ARGN)
    string(APPEND lines "${macro}(${name})\n")
  endforeach()
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/${folder}/${file} CONTENT "${lines}" @ONLY)
endfunction()
