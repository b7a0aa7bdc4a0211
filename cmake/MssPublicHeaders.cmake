# mss_public_headers(TARGET FOLDER HEADER...): what other programs include, as <mss/FOLDER/HEADER>, from a build as from an
# installation. These are copies that include each other by those names; whoever works on mss itself uses the sources.
function(mss_public_headers target folder)
  set(copies "")
  foreach(header ${ARGN})
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/${header})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(READ ${source} text)
    string(REGEX REPLACE "#include \"((core|integrators)/[^\"]+)\"" "#include <mss/\\1>" text "${text}")
    set(copy ${PROJECT_BINARY_DIR}/include/mss/${folder}/${header})
    file(CONFIGURE OUTPUT ${copy} CONTENT "${text}" @ONLY)  # only if it differs
    list(APPEND copies ${copy})
  endforeach()
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_BINARY_DIR}/include FILES ${copies})
endfunction()
