# mss_join_by_folder(TARGET [APART SOURCE...]): where CMAKE_UNITY_BUILD is on, the sources of a folder are compiled
# together, which takes half of the time. They then see each other's names: those that have a name in common stay apart.
function(mss_join_by_folder target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" APART)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    if(source MATCHES "\\.cpp$")
      cmake_path(GET source PARENT_PATH folder)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${folder}")
    endif()
  endforeach()
  set_source_files_properties(${arg_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()
