# mss_registry(LIST TYPE HEADER name...) writes the source of `const std::vector<TYPE>& LIST()`, which HEADER declares:
# what the functions `TYPE name()` return, in this order, which lists and charts follow. Its path is left in
# LIST_registry.
function(mss_registry list type header)
  set(declarations "")
  foreach(name IN LISTS ARGN)
    string(APPEND declarations "${type} ${name}();\n")
  endforeach()
  list(TRANSFORM ARGN APPEND "()")
  list(JOIN ARGN ", " calls)
  set(path ${CMAKE_CURRENT_BINARY_DIR}/${list}_registry.cpp)
  file(CONFIGURE OUTPUT ${path} @ONLY CONTENT "// Generated from the list in ${CMAKE_CURRENT_SOURCE_DIR}/CMakeLists.txt.
#include \"${header}\"

namespace mss {

${declarations}
const std::vector<${type}>& ${list}() {
  static const std::vector<${type}> all{${calls}};
  return all;
}

}  // namespace mss
")
  set(${list}_registry ${path} PARENT_SCOPE)
endfunction()
