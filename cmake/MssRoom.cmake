# mss_room(LIBRARY ROOM [FOLDER F] [USES ROOM...] [LINKS TARGET...] [HEADERS H...] [SOURCES NAME...] [APART NAME...]): a
# layer of a library, the folder ROOM (or F) and the sources NAME.cpp in it, above the rooms in USES (of another library as
# LIBRARY::ROOM), with the libraries in LINKS. CMake refuses circles; what is included is tests/source_test.cpp's. HEADERS, given with the
# first room, are compiled once for all. Where CMAKE_UNITY_BUILD is on, SOURCES are compiled together, which takes half of
# the time. They then see each other's names: those that have a name in common, or may have, stay APART.
function(mss_room library room)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "FOLDER" "USES;LINKS;HEADERS;SOURCES;APART")
  if(NOT arg_FOLDER)
    set(arg_FOLDER ${room})
  endif()
  set(target ${library}_${room})
  foreach(sources SOURCES APART)
    list(TRANSFORM arg_${sources} REPLACE "^[^/].*$" "${arg_FOLDER}/\\0.cpp")
  endforeach()
  list(TRANSFORM arg_USES REPLACE "^[^:]+$" "${library}_\\0")
  list(TRANSFORM arg_USES REPLACE "^(.+)::(.+)$" "mss_\\1_\\2")
  add_library(${target} OBJECT ${arg_SOURCES} ${arg_APART})
  target_link_libraries(${target} PUBLIC ${arg_USES} ${arg_LINKS} PRIVATE mss_options)
  set_source_files_properties(${arg_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 0)
  if(arg_HEADERS)
    target_precompile_headers(${target} PRIVATE ${arg_HEADERS})
    set_property(GLOBAL PROPERTY ${library}_headers ${target})
  else()
    get_property(headers GLOBAL PROPERTY ${library}_headers)
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endif()
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:${target}>)
endfunction()
