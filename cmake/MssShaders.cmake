# mss_shader_texts(RESULT FOLDER LAW FILE...) writes the source of shader_text(), declared in core/device/device.hpp: the texts of
# all FOLDER/NAME.glsl by NAME, and of the files, which C++ includes too, by their names; the law of springs as "spring_law".
# Leaves the source's path in RESULT.
function(mss_shader_texts result folder law)
  file(GLOB shaders CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.glsl)
  set(entries "")
  foreach(file ${shaders} ${CMAKE_CURRENT_SOURCE_DIR}/${law} ${ARGN})
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} text)
    get_filename_component(name ${file} NAME)
    string(REGEX REPLACE "\\.glsl$" "" name ${name})
    if(file STREQUAL "${CMAKE_CURRENT_SOURCE_DIR}/${law}")
      set(name spring_law)
    endif()
    string(APPEND entries "      {\"${name}\", R\"glsl(${text})glsl\"},\n")
  endforeach()
  set(path ${CMAKE_CURRENT_BINARY_DIR}/shader_texts)
  file(CONFIGURE OUTPUT ${path}.cpp @ONLY CONTENT "// Generated from ${CMAKE_CURRENT_SOURCE_DIR}/${folder}.
#include <map>
#include <stdexcept>
#include <string>

#include \"core/device/device.hpp\"

namespace mss {

std::string_view shader_text(std::string_view name) {
  static const std::map<std::string, std::string, std::less<>> texts{
${entries}  };
  const auto found = texts.find(name);
  if (found == texts.end()) throw std::logic_error(\"there is no shader text \" + std::string(name));
  return found->second;
}

}  // namespace mss
")
  set(${result} ${path}.cpp PARENT_SCOPE)
endfunction()
